#include "apps/experiment/targetless/camera_experiment.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "apps/experiment/targetless/experiment.h"
#include "apps/experiment/targetless/fixed_voxels.h"
#include "apps/experiment/targetless/mutual_information.h"
#include "tests/core/camera/textured_room.h"
#include "tests/support/json.h"
#include "tests/support/schema_check.h"

namespace rigcal::targetless {
namespace {

CameraSetOptions small() {
  CameraSetOptions options;
  options.points = 30000;
  options.stops = 10;
  options.images = 4;
  options.image_scale = 0.25;
  return options;
}

// With fewer images and points a camera's place is open, and what it comes to hangs on the noise.
CameraSetOptions enough() {
  CameraSetOptions options = small();
  options.points = 60000;
  options.images = 6;
  options.image_scale = 0.5;
  return options;
}

void expect_schema(const Experiment& experiment) {
  const auto json = parse_json(experiment_json(experiment));
  EXPECT_TRUE(fits_schema("experiment_targetless.json", json));
  for (const auto& [name, text] : experiment_files(experiment)) EXPECT_FALSE(text.empty()) << name;
}

TEST(TryCameras, FindsCamerasThatLookWithTheLidarAndTriesThoseThatLookAway) {
  SilentReporter silent;
  Experiment experiment;
  const auto done = try_cameras(1, enough(), {silent});
  ASSERT_TRUE(done) << done.error().message();
  experiment.cameras = *done;
  const std::string text = experiment_text(experiment);
  ASSERT_EQ(done->rows.size(), 12U) << text;
  EXPECT_EQ(std::count_if(done->rows.begin(), done->rows.end(), [](const CameraRow& row) { return row.overlaps; }), 6);
  for (const CameraRow& row : done->rows) {
    EXPECT_EQ(row.trials, row.pair == "LiDAR to camera" ? 2 : 1) << text;
    if (row.method == "rigcal" && row.overlaps) {
      EXPECT_EQ(row.found, row.trials) << text;
      // Six small images and a thin map tell where the cameras look, not where they are to the centimetre.
      EXPECT_LT(row.rotation_rad.mean, 0.25 * done->guess_rotation_rad.mean) << text;
    }
  }
  expect_schema(experiment);
}

TEST(MeasureCameras, TellsFeaturesFromIterations) {
  SilentReporter silent;
  Experiment experiment;
  const auto done = measure_cameras(small(), {silent});
  ASSERT_TRUE(done) << done.error().message();
  experiment.camera_time = *done;
  ASSERT_EQ(done->size(), 3U);
  for (std::size_t k = 0; k < 2; ++k) {
    EXPECT_GT((*done)[k].planes_s, 0.0);
    EXPECT_GT((*done)[k].match_s, 0.0);
    EXPECT_GT((*done)[k].voxels, 50U);
    EXPECT_GT((*done)[k].edge_points, 100U);
  }
  EXPECT_GT((*done)[2].solve_s, 0.0);
  expect_schema(experiment);
}

TEST(FixedVoxels, FindTheEdgeOfTwoWalls) {
  std::vector<Vector3d> points;
  Random random(3);
  for (int k = 0; k < 4000; ++k) {
    const double along = random.uniform(0.05, 0.95);
    const double away = random.uniform(0.0, 0.4);
    points.emplace_back(k % 2 == 0 ? Vector3d(0.3 + away, 0.4, along) : Vector3d(0.3, 0.4 + away, along));
    for (int axis = 0; axis < 3; ++axis) points.back()[axis] += 0.003 * random.normal();
  }
  const FixedVoxelEdges found = find_edges_in_fixed_voxels(points, {});
  EXPECT_EQ(found.voxels, 1U);
  EXPECT_EQ(found.planes, 2U);
  ASSERT_GT(found.edges.size(), 20U);
  for (const LidarEdge& edge : found.edges) {
    EXPECT_LT((edge.p_G - Vector3d(0.3, 0.4, edge.p_G.z())).norm(), 0.003);
    EXPECT_GT(std::abs(edge.direction_G.z()), 0.999);
    EXPECT_EQ(edge.line, 0);
  }
}

TEST(FixedVoxels, AFlatWallHasNoEdge) {
  std::vector<Vector3d> points;
  Random random(4);
  for (int k = 0; k < 2000; ++k) points.emplace_back(random.uniform(), random.uniform(), 0.5 + 0.003 * random.normal());
  EXPECT_TRUE(find_edges_in_fixed_voxels(points, {}).edges.empty());
  EXPECT_TRUE(find_edges_in_fixed_voxels({}, {}).edges.empty());
}

TEST(MaximiseInformation, FindsTheCameraOfAPaintedRoom) {
  const TexturedRoom room = make_textured_room();
  const SE3 guess = room.truth * SE3{exp_so3({0.02, -0.02, 0.01}), {0.03, -0.02, 0.02}};
  const auto found = maximise_information(room.scene, room.camera, guess);
  ASSERT_TRUE(found);
  EXPECT_GT(found->evaluations, 100);
  EXPECT_GT(found->information, 0.1);
  EXPECT_LT(rotation_distance(found->T_base_camera.R, room.truth.R), 0.25 * 0.03);
  EXPECT_LT((found->T_base_camera.t - room.truth.t).norm(), 0.03);
}

TEST(MaximiseInformation, GivesUpWhereTheCameraSeesNothingOfTheMap) {
  TexturedRoom room = make_textured_room();
  room.scene.samples.clear();
  EXPECT_FALSE(maximise_information(room.scene, room.camera, room.truth));
}

}  // namespace
}  // namespace rigcal::targetless
