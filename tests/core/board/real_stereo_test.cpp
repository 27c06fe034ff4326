#include <gtest/gtest.h>

#include "core/board/board_adjustment.h"
#include "core/edges/grey_image.h"
#include "core/io/image_file.h"
#include "tests/support/real_recordings.h"

namespace rigcal {
namespace {

// stereo_board: 13 pairs of images of a board, lengths in squares, intrinsics unknown.
TEST(RealStereo, FindsIntrinsicsAndBaselineFromTheImagesAlone) {
  const auto folder = real_recordings() / "stereo_board";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no real recordings at " << folder;
  BoardSettings settings;
  settings.inner_corners = {9, 6};
  settings.square = 1.0;
  const BoardModel board(settings);
  std::vector<BoardSensor> sensors(2);
  std::vector<BoardSighting> sightings;
  for (int c = 0; c < 2; ++c) {
    const std::string side = c == 0 ? "left" : "right";
    std::vector<ImageBoard> seen;
    std::vector<int> stops;
    for (int number = 1; number <= 14; ++number) {
      if (number == 10) continue;  // is not in the set
      const std::string two_digits = (number < 10 ? "0" : "") + std::to_string(number);
      const auto image = read_image((folder / (side + two_digits + ".jpg")).string());
      ASSERT_TRUE(image);
      for (const ImageBoard& b : find_image_boards(to_grey(*image, 8), board).boards) {
        EXPECT_TRUE(b.whole) << side << number;
        EXPECT_EQ(b.alternatives.size(), 1u);
        seen.push_back(b);
        stops.push_back(number);
      }
    }
    EXPECT_EQ(seen.size(), 13u) << side;
    const auto rough = rough_intrinsics(seen, board, DistortionModel::radtan, 640, 480);
    ASSERT_TRUE(rough);
    EXPECT_NEAR(rough->fx, 534.0, 60.0);
    sensors[static_cast<std::size_t>(c)].name = side;
    sensors[static_cast<std::size_t>(c)].camera = *rough;
    const CameraModel camera(*rough);
    for (std::size_t k = 0; k < seen.size(); ++k) {
      const auto pose = find_image_pose(seen[k], board, camera);
      ASSERT_TRUE(pose);
      sightings.push_back(image_sighting(c, stops[k], seen[k], *pose, board, camera));
    }
  }
  sensors[0].fixed = true;
  const auto placed = place_pair(sightings, 0, 1, board, std::nullopt);
  ASSERT_TRUE(placed);
  EXPECT_GE(placed->agreeing, 8);
  sensors[1].T_base_sensor = placed->T_a_b;
  BoardAdjustOptions options;
  options.refine_intrinsics = true;
  const BoardAdjustment found = adjust_boards(sensors, board_places(sightings, sensors, board), board, options);
  EXPECT_TRUE(found.converged);
  double squares = 0.0;
  double corners = 0.0;
  for (const BoardPlace& place : found.places) {
    EXPECT_TRUE(place.why_out.empty()) << place.why_out;
    for (const BoardSighting& s : place.sightings) {
      const double count = static_cast<double>(s.image->ids.size());
      const auto& sensor = found.sensors[static_cast<std::size_t>(s.sensor)];
      squares += count * std::pow(residuals_of(s, sensor, place.T_base_board, board).pixels, 2);
      corners += count;
    }
  }
  RecordProperty("reprojection_px", std::to_string(std::sqrt(squares / corners)));
  EXPECT_EQ(corners, 2.0 * 13.0 * 54.0);
  EXPECT_LT(std::sqrt(squares / corners), 0.21);
  const SE3 T_right_left = found.sensors[1].T_base_sensor.inverse();
  RecordProperty("baseline_x", std::to_string(T_right_left.t.x()));
  EXPECT_NEAR(T_right_left.t.x(), -3.3267, 0.01);
  EXPECT_NEAR(T_right_left.t.y(), 0.0372, 0.02);
  EXPECT_NEAR(T_right_left.t.z(), -0.0032, 0.05);
  EXPECT_LT((log_so3(T_right_left.R) * 180.0 / pi - Vector3d(0.388, 0.243, -0.202)).norm(), 0.15);
  EXPECT_NEAR(found.sensors[0].camera->fx, 533.7, 3.0);
}

}  // namespace
}  // namespace rigcal
