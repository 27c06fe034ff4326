#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <memory>

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

constexpr int poses = 12;

struct RealPose {
  std::vector<BoardSighting> sightings;
  std::string why_not;
};

RealPose see_pose(const std::filesystem::path& folder, int number, const BoardModel& board, const CameraModel& camera) {
  const std::string name = "pose" + std::to_string(number);
  RealPose out;
  const auto cloud = read_pcd((folder / "pcd" / (name + "_full.pcd")).string());
  const auto image = read_image((folder / "images" / (name + ".png")).string());
  if (!cloud || !image) return {{}, name + " cannot be read"};
  for (CloudBoard& b : find_ring_boards(cloud->points, board, false).boards) {
    out.sightings.push_back(cloud_sighting(0, number, std::move(b), board));
  }
  for (ImageBoard& b : find_image_boards(to_grey(*image, 8), board).boards) {
    const auto found = find_image_pose(b, board, camera);
    if (!found) return {{}, name + " has a board without a pose"};
    out.sightings.push_back(image_sighting(1, number, std::move(b), *found, board, camera));
  }
  return out;
}

// What all tests look at: found once.
struct RealWorld {
  BoardModel board = real_board();
  PairPlacementByBoards placed;
  std::vector<BoardPlace> places;
  BoardAdjustment all;
};

class RealRings : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    const auto folder = real_recordings() / "board_vlp16_fisheye";
    if (!std::filesystem::exists(folder)) return;
    world_ = std::make_unique<RealWorld>();
    const CameraModel camera(real_camera());
    std::vector<RealPose> seen(poses);
    parallel_for(seen.size(), 1, [&](std::size_t begin, std::size_t end) {
      for (std::size_t k = begin; k < end; ++k) {
        seen[k] = see_pose(folder, 2 * static_cast<int>(k) + 1, world_->board, camera);
      }
    });
    std::vector<BoardSighting> sightings;
    for (const RealPose& pose : seen) {
      ASSERT_EQ(pose.why_not, "");
      sightings.insert(sightings.end(), pose.sightings.begin(), pose.sightings.end());
    }
    const auto placed = place_pair(sightings, 0, 1, world_->board, std::nullopt);
    ASSERT_TRUE(placed);
    world_->placed = *placed;
    std::vector<BoardSensor> sensors(2);
    sensors[0].name = "lidar";
    sensors[0].fixed = true;
    sensors[1].name = "camera";
    sensors[1].T_base_sensor = placed->T_a_b;
    sensors[1].camera = real_camera();
    world_->places = board_places(sightings, sensors, world_->board);
    world_->all = adjust_boards(sensors, world_->places, world_->board, {});
  }
  static void TearDownTestSuite() { world_.reset(); }

  void SetUp() override {
    if (!world_) GTEST_SKIP() << "no real recordings at " << real_recordings();
    ASSERT_EQ(world_->places.size(), static_cast<std::size_t>(poses));
  }

  static std::unique_ptr<RealWorld> world_;
};
std::unique_ptr<RealWorld> RealRings::world_;

TEST_F(RealRings, ShowTheBoardInEveryPose) {
  EXPECT_EQ(world_->placed.agreeing, poses);
  EXPECT_EQ(world_->placed.shared, poses);
  EXPECT_LT(world_->placed.runner_up, 0.5);
  const BoardAdjustment& all = world_->all;
  EXPECT_TRUE(all.converged);
  EXPECT_TRUE(all.observable[1]);
  EXPECT_LT(all.sensors[0].sigma_plane_m, 0.0135);
  EXPECT_LT(all.sensors[1].sigma_px, 0.25);
  EXPECT_LT((all.sensors[1].T_base_sensor.t - Vector3d(0.06, 0.0, -0.17)).norm(), 0.05);
  RecordProperty("plane_mm", std::to_string(1e3 * all.sensors[0].sigma_plane_m));
}

TEST_F(RealRings, TellThatRangesAreTooShortAndHowSurelyTheyKnow) {
  const BoardAdjustment& all = world_->all;
  const double offset = all.sensors[0].range_offset_m;
  const double sigma = all.range_offset_sigma_m[0];
  RecordProperty("range_offset_mm", std::to_string(1e3 * offset));
  RecordProperty("range_offset_sigma_mm", std::to_string(1e3 * sigma));
  EXPECT_GT(offset, 3.0 * sigma);
  // Plates as much too wide as half the beam of such a LiDAR.
  EXPECT_NEAR(all.sensors[0].growth_m.mean(), 0.0085, 0.003);
  // The plates' planes alone, against where the camera has them, say the same.
  std::vector<BoardPlace> without_border = world_->places;
  for (BoardPlace& place : without_border) {
    for (BoardSighting& seen : place.sightings) {
      if (seen.cloud) seen.cloud->border.clear();
    }
  }
  BoardAdjustOptions by_planes;
  by_planes.noise_passes = 0;
  by_planes.drop_outliers = false;
  const BoardAdjustment planes = adjust_boards(all.sensors, without_border, world_->board, by_planes);
  RecordProperty("by_planes_mm", std::to_string(1e3 * planes.sensors[0].range_offset_m));
  RecordProperty("by_planes_sigma_mm", std::to_string(1e3 * planes.range_offset_sigma_m[0]));
  EXPECT_GT(planes.sensors[0].range_offset_m, 0.0);
  EXPECT_NEAR(planes.sensors[0].range_offset_m, offset, planes.range_offset_sigma_m[0]);
  EXPECT_GT(planes.range_offset_sigma_m[0], 2.0 * sigma);
}

TEST_F(RealRings, GiveTheExtrinsicsThatTheirHalvesAgreeOn) {
  Random random(1);
  constexpr std::size_t splits = 200;
  std::vector<std::vector<BoardPlace>> shuffled(splits, world_->places);
  for (auto& order : shuffled) {
    for (std::size_t k = order.size(); k > 1; --k) std::swap(order[k - 1], order[random.below(k)]);
  }
  BoardAdjustOptions options;
  options.noise_passes = 1;
  std::vector<double> apart_deg(splits);
  std::vector<double> apart_m(splits);
  std::vector<double> offsets_apart_m(splits);
  std::vector<Vector6d> apart(splits);
  parallel_for(splits, 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      const auto half = shuffled[k].begin() + poses / 2;
      const auto a = adjust_boards(world_->all.sensors, {shuffled[k].begin(), half}, world_->board, options);
      const auto b = adjust_boards(world_->all.sensors, {half, shuffled[k].end()}, world_->board, options);
      const SE3& T_a = a.sensors[1].T_base_sensor;
      const SE3& T_b = b.sensors[1].T_base_sensor;
      apart_deg[k] = to_deg(rotation_distance(T_a.R, T_b.R));
      apart_m[k] = (T_a.t - T_b.t).norm();
      apart[k] = (T_a.inverse() * T_b).log();
      offsets_apart_m[k] = std::abs(a.sensors[0].range_offset_m - b.sensors[0].range_offset_m);
    }
  });
  EXPECT_LT(median(apart_deg), 0.5);
  EXPECT_LT(median(apart_m), 0.020);
  // Two halves differ by twice the sigma of the whole, in the median by 0.67 of that.
  const double offset_sigma_m = median(offsets_apart_m) / (2.0 * 0.67);
  EXPECT_LT(offset_sigma_m, 1.5 * world_->all.range_offset_sigma_m[0]);
  EXPECT_GT(offset_sigma_m, 0.4 * world_->all.range_offset_sigma_m[0]);
  // Four times the variance of the whole, each of rotation and translation.
  const Matrix6d& covariance = world_->all.covariances[1];
  Vector6d squares = Vector6d::Zero();
  for (const Vector6d& xi : apart) squares += xi.cwiseAbs2() / static_cast<double>(splits);
  for (int part = 0; part < 6; part += 3) {
    const double ratio = std::sqrt(squares.segment<3>(part).sum() / (4.0 * covariance.block<3, 3>(part, part).trace()));
    EXPECT_LT(ratio, 1.35) << part;
    EXPECT_GT(ratio, 0.5) << part;
    RecordProperty(part == 0 ? "sigmas_apart_rotation" : "sigmas_apart_translation", std::to_string(ratio));
  }
  RecordProperty("range_offset_sigma_by_halves_mm", std::to_string(1e3 * offset_sigma_m));
  RecordProperty("halves_apart_deg", std::to_string(median(apart_deg)));
  RecordProperty("halves_apart_mm", std::to_string(1e3 * median(apart_m)));
}

}  // namespace
}  // namespace rigcal
