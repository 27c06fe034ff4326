#include <gtest/gtest.h>

#include <algorithm>

#include "core/base/median.h"
#include "core/base/parallel.h"
#include "core/base/random.h"
#include "core/board/board_adjustment.h"
#include "core/edges/grey_image.h"
#include "core/io/image_file.h"
#include "core/io/pcd_file.h"
#include "tests/support/real_recordings.h"

namespace rigcal {
namespace {

// board_vlp16_fisheye: 12 poses of a board before a LiDAR of 16 rings and a fisheye camera.
BoardModel real_board() {
  BoardSettings settings;
  settings.inner_corners = {7, 5};
  settings.square = 0.095;
  settings.size = {0.85, 0.61};
  return BoardModel(settings);
}

CameraIntrinsics real_camera() {
  return {DistortionModel::equidistant,
          1920,
          1208,
          1176.93,
          1177.72,
          962.275,
          612.725,
          {-0.0540096, -0.0784275, 0.0959641, -0.0515253}};
}

class RealRings : public testing::Test {
 protected:
  void SetUp() override {
    const auto folder = real_recordings() / "board_vlp16_fisheye";
    if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no real recordings at " << folder;
    for (int pose = 1; pose <= 23; pose += 2) {
      const std::string name = "pose" + std::to_string(pose);
      const auto cloud = read_pcd((folder / "pcd" / (name + "_full.pcd")).string());
      ASSERT_TRUE(cloud);
      for (CloudBoard& b : find_ring_boards(cloud->points, board_, false).boards) {
        sightings_.push_back(cloud_sighting(0, pose, std::move(b), board_));
      }
      const auto image = read_image((folder / "images" / (name + ".png")).string());
      ASSERT_TRUE(image);
      for (ImageBoard& b : find_image_boards(to_grey(*image, 8), board_).boards) {
        const auto found = find_image_pose(b, board_, camera_);
        ASSERT_TRUE(found) << name;
        sightings_.push_back(image_sighting(1, pose, std::move(b), *found, board_, camera_));
      }
    }
  }

  const BoardModel board_ = real_board();
  const CameraModel camera_{real_camera()};
  std::vector<BoardSighting> sightings_;
};

TEST_F(RealRings, GiveTheExtrinsicsThatTheirHalvesAgreeOn) {
  const auto placed = place_pair(sightings_, 0, 1, board_, std::nullopt);
  ASSERT_TRUE(placed);
  EXPECT_EQ(placed->agreeing, 12);  // a board in both of every pose
  EXPECT_EQ(placed->shared, 12);
  EXPECT_LT(placed->runner_up, 0.5);
  std::vector<BoardSensor> sensors(2);
  sensors[0].name = "lidar";
  sensors[0].fixed = true;
  sensors[1].name = "camera";
  sensors[1].T_base_sensor = placed->T_a_b;
  sensors[1].camera = real_camera();
  const std::vector<BoardPlace> places = board_places(sightings_, sensors, board_);
  ASSERT_EQ(places.size(), 12u);
  const BoardAdjustment all = adjust_boards(sensors, places, board_, {});
  EXPECT_TRUE(all.converged);
  EXPECT_TRUE(all.observable);
  EXPECT_LT(all.sensors[0].sigma_plane_m, 0.0135);
  EXPECT_LT(all.sensors[1].sigma_px, 0.25);
  // Ranges too short, and plates as much too wide as half the beam of such a LiDAR.
  EXPECT_GT(all.sensors[0].range_offset_m, 5.0 * all.range_offset_sigma_m[0]);
  EXPECT_NEAR(all.sensors[0].growth_m.mean(), 0.0085, 0.002);
  // The plates' planes alone, against where the camera has them, say the same.
  std::vector<BoardPlace> without_border = places;
  for (BoardPlace& place : without_border) {
    for (BoardSighting& seen : place.sightings) {
      if (seen.cloud) seen.cloud->border.clear();
    }
  }
  BoardAdjustOptions by_planes;
  by_planes.noise_passes = 0;
  by_planes.drop_outliers = false;
  const BoardAdjustment planes = adjust_boards(all.sensors, without_border, board_, by_planes);
  EXPECT_GT(planes.sensors[0].range_offset_m, planes.range_offset_sigma_m[0]);
  EXPECT_NEAR(planes.sensors[0].range_offset_m, all.sensors[0].range_offset_m, 2.0 * planes.range_offset_sigma_m[0]);
  EXPECT_LT((all.sensors[1].T_base_sensor.t - Vector3d(0.06, 0.0, -0.17)).norm(), 0.05);

  Random random(1);
  constexpr std::size_t splits = 200;
  std::vector<std::vector<BoardPlace>> shuffled(splits, places);
  for (auto& order : shuffled) {
    for (std::size_t k = order.size(); k > 1; --k) std::swap(order[k - 1], order[random.below(k)]);
  }
  BoardAdjustOptions options;
  options.noise_passes = 1;
  std::vector<double> apart_deg(splits);
  std::vector<double> apart_m(splits);
  parallel_for(splits, 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      const auto half = shuffled[k].begin() + 6;
      const auto a = adjust_boards(all.sensors, {shuffled[k].begin(), half}, board_, options);
      const auto b = adjust_boards(all.sensors, {half, shuffled[k].end()}, board_, options);
      const SE3& T_a = a.sensors[1].T_base_sensor;
      const SE3& T_b = b.sensors[1].T_base_sensor;
      apart_deg[k] = to_deg(rotation_distance(T_a.R, T_b.R));
      apart_m[k] = (T_a.t - T_b.t).norm();
    }
  });
  EXPECT_LT(median(apart_deg), 0.5);
  EXPECT_LT(median(apart_m), 0.020);
  RecordProperty("halves_apart_deg", std::to_string(median(apart_deg)));
  RecordProperty("halves_apart_mm", std::to_string(1e3 * median(apart_m)));
  RecordProperty("plane_mm", std::to_string(1e3 * all.sensors[0].sigma_plane_m));
  RecordProperty("range_offset_mm", std::to_string(1e3 * all.sensors[0].range_offset_m));
}

}  // namespace
}  // namespace rigcal
