// What the checkerboard method says where something is wrong with the boards.
#include "core/pipeline/board_calibration.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/board_pictures.h"
#include "tests/support/noting_reporter.h"
#include "tests/support/ring_scans.h"

namespace rigcal {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;
using testing::Not;

CameraIntrinsics test_camera() {
  return {DistortionModel::radtan, 640, 480, 420.0, 420.0, 319.5, 239.5, {0.0, 0.0, 0.0, 0.0, 0.0}};
}

// A LiDAR "front" (the base) and one more sensor "side": a LiDAR half a metre away, or a camera.
class BoardCalibrationTest : public testing::Test {
 protected:
  BoardCalibrationTest() {
    rig_.name = "boards";
    rig_.sensors.resize(2);
    rig_.sensors[0].name = "front";
    rig_.sensors[0].lidar.emplace().rings = true;
    rig_.sensors[1].name = "side";
    rig_.board = BoardSettings{"checkerboard", {7, 5}, 0.095, {0.85, 0.61}, {0.0, 0.0}};
  }

  void with_lidar() { rig_.sensors[1].lidar.emplace().rings = true; }
  void with_camera() {
    rig_.sensors[1].camera.emplace().intrinsics = test_camera();
    T_front_side_.R << 0.0, 0.0, 1.0, -1.0, 0.0, 0.0, 0.0, -1.0, 0.0;
    T_front_side_.t = {0.05, 0.1, -0.1};
  }

  // Plates at the next stop, in the frame of "front", of a size that need not be the rig file's.
  void show(const std::vector<SE3>& plates, const Eigen::Vector2d& size) {
    const int stop = static_cast<int>(stops_.size());
    stops_.push_back({stop, 0, 0});
    patches_.push_back({0, stop, ring_scan(plates, size, 0.01, random_)});
    std::vector<SE3> there;
    for (const SE3& T : plates) there.push_back(T_front_side_.inverse() * T);
    if (rig_.sensors[1].lidar) {
      patches_.push_back({1, stop, ring_scan(there, size, 0.01, random_)});
      return;
    }
    const BoardModel printed({"checkerboard", {7, 5}, printed_square_, {size.x(), size.y()}, {0.0, 0.0}});
    images_.push_back({stop, "", as_image(board_picture(CameraModel(test_camera()), there, printed))});
  }

  SensorResult side(std::uint64_t seed = 1) {
    options_.seed = seed;
    std::vector<CameraRecording> cameras;
    for (std::size_t s = 1; s < rig_.sensors.size(); ++s) {
      if (!rig_.sensors[s].camera) continue;
      cameras.push_back({static_cast<int>(s), std::nullopt, [this](const RunContext&) {
                           return StillImages{images_, "no image"};
                         }});
    }
    const std::vector<std::optional<SE3>> guess(rig_.sensors.size());
    auto result = calibrate_by_boards(rig_, {stops_, patches_, cameras}, guess, options_, {reporter_});
    EXPECT_TRUE(result) << result.error().what;
    if (!result) return {};
    front_ = result->sensors.front();
    last_ = result->sensors.back();
    cameras_ = result->cameras;
    return result->sensors[1];
  }

  const Eigen::Vector2d size_{0.85, 0.61};
  double printed_square_ = 0.095;
  SE3 T_front_side_{exp_so3({0.05, -0.05, 0.3}), {0.1, 0.5, -0.1}};
  Rig rig_;
  std::vector<Stop> stops_;
  std::vector<Patch> patches_;
  std::vector<StillImage> images_;
  BoardCalibrationOptions options_;
  SensorResult front_;
  SensorResult last_;
  std::vector<CameraEvidence> cameras_;
  NotingReporter reporter_;
  Random random_{21};
};

TEST_F(BoardCalibrationTest, SaysThatThereIsNoBoard) {
  with_lidar();
  show({}, size_);
  show({}, size_);
  const SensorResult lidar = side();
  EXPECT_EQ(lidar.status, Status::failed);
  EXPECT_THAT(lidar.reasons, Contains(HasSubstr("no board was found in what it saw: no flat piece of 0.85 by 0.61 m "
                                                "that stands free (2 stops, the first is 0)")));
}

TEST_F(BoardCalibrationTest, TellsOfACameraThatHasNoIntrinsicsThatItIsOne) {
  with_camera();
  rig_.sensors[1].camera->intrinsics.reset();
  stops_.push_back({0, 0, 0});
  EXPECT_THAT(side().reasons, Contains(HasSubstr("the rig file has no intrinsics for it")));
  ASSERT_EQ(cameras_.size(), 1U);
  EXPECT_EQ(cameras_[0].name, "side");
  EXPECT_FALSE(cameras_[0].estimate.found);
  EXPECT_EQ(cameras_[0].given.width, 0);
}

TEST_F(BoardCalibrationTest, SaysWhyTheBaseSawNoBoard) {
  with_camera();
  rig_.board->size = {850.0, 610.0};
  show({plate_at(0.0, 2.0, 0.8, 0.1)}, size_);
  const SensorResult camera = side();
  EXPECT_EQ(front_.status, Status::failed);
  EXPECT_FALSE(front_.T_base_sensor);
  EXPECT_THAT(front_.reasons, Contains(HasSubstr("no board was found in what it saw: no flat piece of 850.0 by")));
  EXPECT_EQ(camera.status, Status::failed);
  EXPECT_THAT(camera.reasons, Contains(HasSubstr("but not in what front, the base, saw")));
}

TEST_F(BoardCalibrationTest, SaysOfSquaresInMillimetresThatBoundsAreInMetres) {
  rig_.sensors[0].lidar.reset();
  rig_.sensors[0].camera.emplace().intrinsics = test_camera();
  with_camera();
  stops_.push_back({0, 0, 0});
  side();
  EXPECT_THAT(reporter_.warnings, Not(Contains(HasSubstr("are in metres"))));
  rig_.board = BoardSettings{"checkerboard", {7, 5}, 30.0, {0.0, 0.0}, {0.0, 0.0}};
  side();
  EXPECT_THAT(reporter_.warnings, Contains(HasSubstr("board.square is 30.0, and bounds and --require are in metres")));
}

TEST_F(BoardCalibrationTest, IsTheSameWhateverIsDrawn) {
  with_lidar();
  for (int k = 0; k < 6; ++k)
    show({plate_at(0.2 * k - 0.5, 2.0 + 0.1 * (k % 3), 0.6 + 0.1 * (k % 4), 0.3 * ((k % 3) - 1))}, size_);
  const SensorResult usual = side();
  const SensorResult again = side();
  const SensorResult other = side(2);
  ASSERT_TRUE(usual.T_base_sensor && again.T_base_sensor && other.T_base_sensor);
  EXPECT_EQ(usual.T_base_sensor->matrix(), again.T_base_sensor->matrix());
  // Other draws mostly end with the same points.
  EXPECT_LT((usual.T_base_sensor->t - other.T_base_sensor->t).norm(), 0.02);
}

TEST_F(BoardCalibrationTest, FailsNoOtherSensorForACameraThatSawTheBoardOnce) {
  with_lidar();
  const auto plate = [](int k) {
    return plate_at(0.2 * k - 0.5, 2.0 + 0.1 * (k % 3), 0.6 + 0.1 * (k % 4), 0.3 * ((k % 3) - 1));
  };
  for (int k = 0; k < 6; ++k) show({plate(k)}, size_);
  const SensorResult alone = side();
  ASSERT_TRUE(alone.T_base_sensor);
  rig_.sensors.resize(3);
  rig_.sensors[2].name = "once";
  rig_.sensors[2].camera.emplace().intrinsics = test_camera();
  SE3 T_front_once;
  T_front_once.R << 0.0, 0.0, 1.0, -1.0, 0.0, 0.0, 0.0, -1.0, 0.0;
  T_front_once.t = {0.05, 0.1, -0.1};
  images_.push_back({2, "",
                     as_image(board_picture(CameraModel(test_camera()), {T_front_once.inverse() * plate(2)},
                                            BoardModel(*rig_.board)))});
  options_.refine_intrinsics = true;
  const SensorResult lidar = side();
  EXPECT_EQ(last_.status, Status::failed);
  EXPECT_THAT(last_.reasons, Contains(HasSubstr("leave its place open")));
  EXPECT_EQ(lidar.status, alone.status);
  ASSERT_TRUE(lidar.T_base_sensor);
  EXPECT_LT((lidar.T_base_sensor->t - alone.T_base_sensor->t).norm(), 0.005);
  EXPECT_LT(lidar.covariance.trace(), 1.2 * alone.covariance.trace());
}

TEST_F(BoardCalibrationTest, SaysThatAnImageHasNoBoard) {
  with_camera();
  show({}, size_);
  EXPECT_THAT(side().reasons, Contains(HasSubstr("no checkerboard of 7 by 5 inner corners in it (1 stop, the first is "
                                                 "0)")));
}

TEST_F(BoardCalibrationTest, SaysThatTwoBoardsLookAlike) {
  with_lidar();
  show({plate_at(0.0, 2.0, 0.8, 0.1), plate_at(1.3, 2.2, 0.7, -0.2)}, size_);
  const SensorResult lidar = side();
  EXPECT_EQ(lidar.status, Status::failed);
  EXPECT_THAT(lidar.reasons,
              Contains(HasSubstr("there are boards that look alike, and which is which cannot be told")));
}

TEST_F(BoardCalibrationTest, SaysThatTheImageCutsTheBoard) {
  with_camera();
  show({plate_at(0.58, 1.9, 0.2, 0.2)}, size_);
  side();
  EXPECT_THAT(reporter_.warnings, Contains(HasSubstr("side: the board is cut by the image border")));
}

TEST_F(BoardCalibrationTest, SaysThatThePlateHasAnotherSize) {
  with_lidar();
  for (int k = 0; k < 6; ++k) {
    show({plate_at(0.2 * k - 0.5, 2.0 + 0.1 * (k % 3), 0.6 + 0.1 * (k % 4), 0.3 * ((k % 3) - 1))}, {0.91, 0.61});
  }
  side();
  EXPECT_THAT(reporter_.warnings, Contains(HasSubstr("but the rig file's board.size is 0.850 by 0.610 m; measure it")));
}

TEST_F(BoardCalibrationTest, SaysThatTheSquaresHaveAnotherSize) {
  with_camera();
  printed_square_ = 0.085;
  for (int k = 0; k < 4; ++k) {
    show({plate_at(0.18 * k - 0.25, 1.7 + 0.5 * (k % 2), 0.5 + 0.1 * (k % 4), 0.3 * ((k % 3) - 1))}, size_);
  }
  const SensorResult camera = side();
  EXPECT_THAT(camera.reasons, Not(Contains(HasSubstr("count the corners"))));
  EXPECT_THAT(reporter_.warnings, Contains(HasSubstr("but the rig file's board.square is 0.0950; measure them")));
  EXPECT_NE(camera.status, Status::good);
}

// Half a square to the side in every image: what is found fits, and is wrong.
TEST_F(BoardCalibrationTest, SaysThatSquaresWereCountedForCorners) {
  with_camera();
  rig_.board->inner_corners = {8, 6};
  for (int k = 0; k < 6; ++k) {
    show({plate_at(0.18 * k - 0.45, 1.7 + 0.5 * (k % 2), 0.5 + 0.1 * (k % 4), 0.3 * ((k % 3) - 1))}, size_);
  }
  const SensorResult camera = side();
  EXPECT_NE(camera.status, Status::good);
  ASSERT_FALSE(camera.reasons.empty());
  EXPECT_THAT(camera.reasons[0], AllOf(HasSubstr("no image shows a whole board of 8 by 6 inner corners"),
                                       HasSubstr("count the corners between the squares")));
}

// Half of the poses agree, and the place is theirs.
TEST_F(BoardCalibrationTest, SaysThatTheMountSlippedHalfway) {
  with_lidar();
  options_.require = {0.05, to_rad(2.0)};
  for (int k = 0; k < 10; ++k) {
    if (k == 5) T_front_side_.t.x() += 0.1;
    show({plate_at(0.2 * ((3 * k) % 10) - 0.9, 2.0 + 0.1 * (k % 3), 0.6 + 0.1 * (k % 4), 0.3 * ((k % 3) - 1))}, size_);
  }
  const SensorResult lidar = side();
  EXPECT_EQ(lidar.status, Status::weak);
  EXPECT_THAT(lidar.reasons, Contains(HasSubstr("a mount that slipped")));
  EXPECT_THAT(reporter_.warnings, Contains(HasSubstr("hold nothing of side")));
}

}  // namespace
}  // namespace rigcal
