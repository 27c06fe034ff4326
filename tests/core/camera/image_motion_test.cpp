#include "core/camera/image_motion.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "core/base/random.h"
#include "tests/core/camera/textured_room.h"

namespace rigcal {
namespace {

Vector3d somewhere(Random& random) { return Vector3d(random.normal(), random.normal(), random.normal()).normalized(); }

// A camera half a metre beside the axis among things 2 to 12 m away; half of the pairs are none.
TEST(CameraAxis, IsFoundFromBesideItAmongAsManyWrongPairs) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    Random random(seed);
    const Vector3d truth = somewhere(random);
    const Vector3d lever = 0.5 * truth.cross(somewhere(random)).normalized();
    std::vector<SeenTwice> pairs;
    for (int k = 0; k < 600; ++k) {
      const double turn = to_rad(k % 2 == 0 ? 18.0 : -27.0);
      const Matrix3d R = exp_so3(turn * truth);
      const Vector3d second = (Vector3d::UnitZ() + 0.4 * somewhere(random)).normalized();
      const Vector3d first = R * (random.uniform(2.0, 12.0) * second) + R * lever - lever;
      const Vector3d seen = first.normalized() + to_rad(0.1) * somewhere(random);
      pairs.push_back({turn, k % 4 < 2 ? seen.normalized() : somewhere(random), second});
    }
    const auto found = find_camera_axis(pairs);
    ASSERT_TRUE(found);
    EXPECT_LT(std::acos(std::min(1.0, found->axis_camera.dot(truth))), to_rad(0.5)) << "seed " << seed;
    EXPECT_LT(std::acos(std::min(1.0, found->lever_camera.dot(lever.normalized()))), to_rad(10.0)) << "seed " << seed;
    EXPECT_GT(found->share, 0.3);
  }
}

TEST(CameraAxis, IsNotMadeUpFromTooFewPairs) {
  Random random(3);
  std::vector<SeenTwice> pairs;
  for (int k = 0; k < 29; ++k) pairs.push_back({0.3, somewhere(random), somewhere(random)});
  EXPECT_FALSE(find_camera_axis(pairs));
  for (int k = 0; k < 71; ++k) pairs.push_back({0.3, somewhere(random), somewhere(random)});
  EXPECT_FALSE(find_camera_axis(pairs)) << "none of a hundred goes with another";
}

TEST(MatchImages, TellsHowACameraIsTurnedTowardsTheAxis) {
  const TexturedRoom room = make_textured_room(true, 16);
  const std::vector<SeenTwice> pairs = match_images(room.scene, room.camera);
  EXPECT_GT(pairs.size(), 300U);
  const auto axis = find_camera_axis(pairs);
  ASSERT_TRUE(axis);
  const Vector3d truth = room.truth.R.transpose() * Vector3d::UnitZ();
  EXPECT_LT(std::acos(std::min(1.0, axis->axis_camera.dot(truth))), to_rad(1.5));
}

TEST(MatchImages, NeedsATurnThatTwoImagesSee) {
  TexturedRoom room = make_textured_room();
  EXPECT_TRUE(match_images(room.scene, room.camera).empty()) << "quarter turns";
  for (SE3& T : room.scene.T_G_base) T.R = Matrix3d::Identity();
  EXPECT_TRUE(match_images(room.scene, room.camera).empty()) << "no turn";
  room.camera.views.clear();
  EXPECT_TRUE(match_images(room.scene, room.camera).empty());
}

}  // namespace
}  // namespace rigcal
