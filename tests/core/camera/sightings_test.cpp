#include "core/camera/sightings.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "tests/core/camera/textured_room.h"

namespace rigcal {
namespace {

class SightingsTest : public testing::Test {
 protected:
  [[nodiscard]] std::vector<Sighting> seen(const SightingOptions& options = {}) const {
    return find_sightings(room_.scene, codes_, room_.camera, model_, room_.truth, options);
  }
  [[nodiscard]] SE3 T_camera_G(std::size_t view) const { return (room_.scene.T_G_base[view] * room_.truth).inverse(); }

  // The sample of the map that lies there. They are sorted along a direction in which no wall is flat.
  [[nodiscard]] std::optional<std::size_t> sample_at(const Vector3d& p_G) {
    const auto along = [](const Vector3d& p) { return p.dot(Vector3d(1.0, 0.731, 0.377)); };
    if (sorted_.empty()) {
      for (std::size_t k = 0; k < room_.scene.samples.size(); ++k)
        sorted_.emplace_back(along(room_.scene.samples[k].p_G.cast<double>()), k);
      std::sort(sorted_.begin(), sorted_.end());
    }
    constexpr double near_m = 1e-5;
    auto at = std::lower_bound(sorted_.begin(), sorted_.end(), std::pair{along(p_G) - 2.0 * near_m, std::size_t{0}});
    for (; at != sorted_.end() && at->first < along(p_G) + 2.0 * near_m; ++at) {
      if ((room_.scene.samples[at->second].p_G.cast<double>() - p_G).norm() < near_m) return at->second;
    }
    return std::nullopt;
  }

  std::vector<std::pair<double, std::size_t>> sorted_;
  TexturedRoom room_ = make_textured_room();
  SurfaceCodes codes_ = surface_codes(room_.scene.samples);
  CameraModel model_{room_.camera.intrinsics};
};

TEST_F(SightingsTest, AreWhatTheCameraSees) {
  const std::vector<Sighting> sightings = seen();
  std::vector<int> of_view(4, 0);
  int wrong = 0;
  for (const Sighting& s : sightings) {
    ++of_view[s.view];
    const Vector3d p_G = room_.scene.T_G_base[s.view] * s.p_base.cast<double>();
    const auto sample = sample_at(p_G);
    ASSERT_TRUE(sample);
    EXPECT_EQ(s.code, codes_.of_sample[*sample]);
    EXPECT_TRUE(model_.contains(*model_.project(T_camera_G(s.view) * p_G)));
    // By a ray: nothing nearer, but for what the buffer's tolerance lets pass.
    const SE3 T_G_camera = T_camera_G(s.view).inverse();
    textured_room::Hit hit;
    const Vector3d ray = p_G - T_G_camera.t;
    textured_room::meet(textured_room::walls, true, T_G_camera.t, ray, hit);
    textured_room::meet(textured_room::cupboard, false, T_G_camera.t, ray, hit);
    if (hit.range_m < 0.9) ++wrong;  // ray ends at 1
  }
  for (const int n : of_view) EXPECT_GT(n, 3000);
  EXPECT_LT(wrong, static_cast<int>(sightings.size() / 500));
}

TEST_F(SightingsTest, SilhouettesAndBordersCanBeLeftOut) {
  const std::size_t all = seen().size();
  SightingOptions options;
  options.silhouette_cells = 2;
  const std::size_t inner = seen(options).size();
  EXPECT_LT(inner, all);
  EXPECT_GT(inner, all / 2);
  options = {};
  options.margin_px = 40.0;
  for (const Sighting& s : seen(options)) {
    const auto pixel = model_.project(room_.truth.inverse() * s.p_base.cast<double>());
    ASSERT_TRUE(model_.contains(*pixel, 39.9));
  }
}

TEST_F(SightingsTest, AsManyAsWanted) {
  SightingOptions options;
  options.max_sightings = 5000;
  const std::vector<Sighting> some = seen(options);
  EXPECT_EQ(some.size(), 5000U);
  std::vector<int> of_view(4, 0);
  for (const Sighting& s : some) ++of_view[s.view];
  for (const int n : of_view) EXPECT_GT(n, 500);
  options.max_samples = room_.scene.samples.size() / 4;
  EXPECT_EQ(seen(options).size(), 5000U);
}

TEST_F(SightingsTest, ViewsThatCannotBeUsedHaveNone) {
  room_.scene.stop_known[1] = 0;
  room_.camera.views[2].grey.width = 100;
  room_.camera.views[3].stop = 99;
  for (const Sighting& s : seen()) ASSERT_EQ(s.view, 0);
}

TEST_F(SightingsTest, AWidenedCameraSeesMore) {
  const CameraModel wide = widened(model_, to_rad(10.0), 2.0);
  for (const double x : {0.0, 319.0}) {
    for (const double y : {0.0, 239.0}) {
      const Vector3d corner = *model_.ray({x, y});
      ASSERT_TRUE(wide.project(corner));
      EXPECT_TRUE(wide.contains(*wide.project(corner)));
    }
  }
  const double half_view = std::acos(model_.ray({0.0, 0.0})->z());
  const auto at = [&](double rad) { return wide.contains(*wide.project({std::sin(rad), 0.0, std::cos(rad)})); };
  EXPECT_TRUE(at(half_view + to_rad(9.0)));
  EXPECT_FALSE(at(half_view + to_rad(11.0)));
}

}  // namespace
}  // namespace rigcal
