#include "core/camera/information.h"

#include <gtest/gtest.h>

#include "core/base/parallel.h"
#include "core/camera/information_cost.h"
#include "core/camera/information_images.h"
#include "core/geometry/matrix6.h"
#include "tests/core/camera/textured_room.h"

namespace rigcal {
namespace {

class InformationTest : public testing::Test {
 protected:
  static const TexturedRoom& room() {
    static const TexturedRoom shared = make_textured_room();
    return shared;
  }

  // The truth turned and shifted, some way or other.
  static SE3 off(double rad, double m, std::uint64_t seed) {
    Random random(seed);
    const Vector3d axis(random.normal(), random.normal(), random.normal());
    const Vector3d shift(random.normal(), random.normal(), random.normal());
    return {room().truth.R * exp_so3(rad * axis.normalized()), room().truth.t + m * shift.normalized()};
  }
  static double rad_off(const SE3& T) { return rotation_distance(T.R, room().truth.R); }
  static double m_off(const SE3& T) { return (T.t - room().truth.t).norm(); }

  [[nodiscard]] std::optional<InformationSearch> search(const TexturedRoom& r, const SE3& guess) const {
    return search_information(r.scene, r.camera, guess, {}, context_);
  }
  [[nodiscard]] std::optional<PoseEstimate> refine(const TexturedRoom& r, const SE3& start) const {
    return refine_information(r.scene, r.camera, r.camera.intrinsics, start, context_);
  }

  mutable SilentReporter silent_;
  RunContext context_{silent_};
};

TEST_F(InformationTest, GradientAgreesWithDifferences) {
  const TexturedRoom& r = room();
  const SurfaceCodes codes = surface_codes(r.scene.samples);
  const CameraModel model(r.camera.intrinsics);
  SightingOptions inner;
  inner.margin_px = 20.0;  // nothing leaves the image
  const SE3 T = off(0.01, 0.02, 3);
  const std::vector<Sighting> sightings = find_sightings(r.scene, codes, r.camera, model, T, inner);
  ASSERT_GT(sightings.size(), 10'000U);
  for (const int halvings : {0, 2}) {
    const std::vector<SmoothImage> images = information_images(r.scene, r.camera, halvings, Shown::contrast);
    const InformationCost cost(model, sightings, images);
    const InformationCost::Derivatives d = cost.derivatives(T);
    EXPECT_NEAR(d.value, cost.value(T).distance, 1e-6);
    for (int k = 0; k < 6; ++k) {
      // Wide enough that single precision does not show.
      const double step = 2e-4;
      const double change = cost.value(T * SE3::exp(step * Vector6d::Unit(k))).distance -
                            cost.value(T * SE3::exp(-step * Vector6d::Unit(k))).distance;
      EXPECT_NEAR(d.gradient[k], change / (2.0 * step), 0.02 * d.gradient.norm()) << halvings << " " << k;
    }
  }
}

TEST_F(InformationTest, FindsTheBasinAndThenTheCamera) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    const auto found = search(room(), off(to_rad(5.0), 0.1, seed));
    ASSERT_TRUE(found);
    EXPECT_LT(rad_off(found->best.T_base_camera), to_rad(0.6));
    EXPECT_LT(m_off(found->best.T_base_camera), 0.06);
    EXPECT_LT(found->best.distance, 0.95);
    if (found->runner_up) {
      EXPECT_GT(found->runner_up->distance, found->best.distance);
    }
    const auto refined = refine(room(), found->best.T_base_camera);
    ASSERT_TRUE(refined);
    EXPECT_LT(rad_off(refined->T_base_camera), to_rad(0.06));
    EXPECT_LT(m_off(refined->T_base_camera), 0.005);
    const Vector6d xi = (room().truth.inverse() * refined->T_base_camera).log();
    EXPECT_LT(xi.dot(solve_symmetric6(refined->covariance, xi)) / 6.0, 3.0);
    EXPECT_LT(std::sqrt(Matrix3d(refined->covariance.topLeftCorner(3, 3)).trace()), to_rad(0.3));
  }
}

TEST_F(InformationTest, ExposureMakesNoDifference) {
  TexturedRoom dim = room();
  for (std::size_t v = 0; v < dim.camera.views.size(); ++v) {
    const float gain = 0.5F + 0.1F * static_cast<float>(v);
    for (float& grey : dim.camera.views[v].grey.values) grey = gain * grey + 6.0F * static_cast<float>(v);
  }
  const auto refined = refine(dim, off(to_rad(0.3), 0.02, 5));
  ASSERT_TRUE(refined);
  EXPECT_LT(rad_off(refined->T_base_camera), to_rad(0.06));
  EXPECT_LT(m_off(refined->T_base_camera), 0.005);
}

TEST_F(InformationTest, ShadingAloneShowsTheWayWhereThereIsNoReflectivity) {
  TexturedRoom plain = make_textured_room(false);
  const auto found = search(plain, off(to_rad(4.0), 0.05, 7));
  ASSERT_TRUE(found);
  EXPECT_LT(rad_off(found->best.T_base_camera), to_rad(2.5));
  for (MapSample& sample : plain.scene.samples) sample.normal_G.setZero();
  EXPECT_FALSE(search(plain, room().truth));
  EXPECT_FALSE(refine(plain, room().truth)) << "a still cost is no certainty";
}

TEST_F(InformationTest, SaysNothingWhereThereIsNothing) {
  TexturedRoom black = room();
  for (CameraView& view : black.camera.views) std::fill(view.grey.values.begin(), view.grey.values.end(), 3.0F);
  EXPECT_FALSE(search(black, black.truth));
  TexturedRoom empty = room();
  empty.scene.samples.clear();
  EXPECT_FALSE(search(empty, empty.truth));
  EXPECT_FALSE(refine(empty, empty.truth));
  TexturedRoom blind = room();
  blind.camera.views.clear();
  EXPECT_FALSE(search(blind, blind.truth));
  EXPECT_FALSE(refine(blind, blind.truth));
  TexturedRoom lost = room();
  lost.scene.stop_known.assign(4, 0);
  EXPECT_FALSE(search(lost, lost.truth));
}

TEST_F(InformationTest, NoiseDoesNotLeadAway) {
  TexturedRoom noisy = room();
  Random random(9);
  for (CameraView& view : noisy.camera.views) {
    for (float& grey : view.grey.values) grey = static_cast<float>(random.uniform(0.0, 255.0));
  }
  const auto found = search(noisy, noisy.truth);
  if (found) {
    EXPECT_LT(m_off(found->best.T_base_camera), 0.3);
  }
}

TEST_F(InformationTest, TheSameWithAnyNumberOfThreads) {
  const SE3 guess = off(to_rad(3.0), 0.05, 8);
  const int before = thread_count();
  std::vector<InformationPose> found;
  std::vector<PoseEstimate> refined;
  for (const int threads : {1, 3}) {
    set_thread_count(threads);
    found.push_back(search(room(), guess)->best);
    refined.push_back(*refine(room(), found[0].T_base_camera));
  }
  set_thread_count(before);
  EXPECT_EQ(found[0].T_base_camera.matrix(), found[1].T_base_camera.matrix());
  EXPECT_EQ(found[0].distance, found[1].distance);
  EXPECT_EQ(refined[0].T_base_camera.matrix(), refined[1].T_base_camera.matrix());
  EXPECT_EQ(refined[0].covariance, refined[1].covariance);
}

TEST_F(InformationTest, StopsWhenAsked) {
  std::stop_source stop;
  stop.request_stop();
  const RunContext stopped{silent_, stop.get_token()};
  EXPECT_FALSE(search_information(room().scene, room().camera, room().truth, {}, stopped));
  EXPECT_FALSE(refine_information(room().scene, room().camera, room().camera.intrinsics, room().truth, stopped));
}

}  // namespace
}  // namespace rigcal
