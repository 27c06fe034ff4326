#include "core/pipeline/surface_cuts.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace rigcal {
namespace {

// A floor at z = -1 and a wall at x = 4, each a leaf that both LiDARs see; the second LiDAR's points stand off by what
// its extrinsic is wrong.
struct Scene {
  std::vector<PatchCells> patches = std::vector<PatchCells>(2);
  std::vector<PlaneFeature> features = std::vector<PlaneFeature>(2);
  RigState truth;
  RigState shifted;

  Scene() {
    truth.T_G_base.resize(1);
    truth.T_base_sensor.resize(2);
    shifted = truth;
    shifted.T_base_sensor[1].t = Vector3d(0.1, 0.0, 0.02);
    for (int lidar = 0; lidar < 2; ++lidar) {
      patches[static_cast<std::size_t>(lidar)].lidar = lidar;
      add(0, lidar, Vector3d(4.0, 0.0, 0.0), Vector3d::UnitY(), Vector3d::UnitZ());
      add(1, lidar, Vector3d(2.0, 0.0, -1.0), Vector3d::UnitX(), Vector3d::UnitY());
    }
  }

  void add(std::size_t k, int lidar, const Vector3d& center, const Vector3d& u, const Vector3d& v) {
    PlaneObservation o;
    o.lidar = lidar;
    o.mean = center;
    o.offset_variance = 1e-6;
    for (int i = -20; i <= 20; ++i) {
      for (int j = -20; j <= 20; ++j) {
        const Vector3d p = center + 0.05 * (i * u + j * v);
        patches[static_cast<std::size_t>(lidar)].thinned.push_back(
            {static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z()), 0, 0, 0});
        o.scatter += (p - center) * (p - center).transpose();
        o.N += 1.0;
      }
    }
    features[k].observations.push_back(o);
  }
};

TEST(SurfaceCuts, ShowHowFarTheSensorsStandOffBeforeAndAfter) {
  const Scene scene;
  const auto cuts = cut_surfaces(scene.features, scene.patches, scene.shifted, scene.truth, {1, 1}, {3, 7});
  ASSERT_EQ(cuts.size(), 2U);
  for (const SurfaceCut& cut : cuts) {
    const double shift = std::abs(cut.normal_G.x()) > 0.9 ? 0.1 : 0.02;
    EXPECT_GE(cut.half_depth_m, shift);
    const auto farthest = [](const std::vector<SurfaceCut::Dot>& dots, int sensor) {
      double off = 0.0;
      for (const SurfaceCut::Dot& dot : dots) {
        if (dot.sensor == sensor) off = std::max(off, static_cast<double>(std::abs(dot.off_m)));
      }
      return off;
    };
    EXPECT_GT(cut.before.size(), 100U);
    EXPECT_NEAR(farthest(cut.before, 7), shift, 1e-5);
    EXPECT_NEAR(farthest(cut.before, 3), 0.0, 1e-5);
    EXPECT_NEAR(farthest(cut.after, 7), 0.0, 1e-5);
    EXPECT_GT(cut.after.size(), 100U);
  }
}

TEST(SurfaceCuts, KeepToTheirNumberOfDotsAndToWhatIsUsed) {
  const Scene scene;
  const auto cuts = cut_surfaces(scene.features, scene.patches, scene.shifted, scene.truth, {1, 0}, {3, 7}, 50);
  ASSERT_EQ(cuts.size(), 2U);
  EXPECT_EQ(cuts[0].before.size(), 50U);
  EXPECT_TRUE(std::all_of(cuts[0].before.begin(), cuts[0].before.end(), [](const auto& d) { return d.sensor == 3; }));
}

TEST(SurfaceCuts, AreNotDrawnWhereNothingOfASurfaceIsNearEnoughBefore) {
  const Scene scene;
  RigState low = scene.truth;
  for (SE3& T : low.T_base_sensor) T.t.z() = -0.9;
  const auto cuts = cut_surfaces(scene.features, scene.patches, low, scene.truth, {1, 1}, {3, 7});
  ASSERT_EQ(cuts.size(), 1U);
  EXPECT_GT(std::abs(cuts[0].normal_G.x()), 0.9) << "the wall, not the floor";
}

}  // namespace
}  // namespace rigcal
