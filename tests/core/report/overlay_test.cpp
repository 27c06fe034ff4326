#include "core/report/overlay.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/io/image_file.h"

namespace rigcal {
namespace {

using testing::ElementsAre;

CameraIntrinsics small_camera() {
  CameraIntrinsics intrinsics;
  intrinsics.width = 320;
  intrinsics.height = 240;
  intrinsics.fx = intrinsics.fy = 200.0;
  intrinsics.cx = 160.0;
  intrinsics.cy = 120.0;
  intrinsics.distortion.assign(5, 0.0);
  return intrinsics;
}

GreyImage flat_image(float grey) { return {320, 240, std::vector<float>(320 * 240, grey)}; }

// The world is the camera's frame: a wall 4 m in front with an upright edge in its middle, the lower half of which a
// board 2 m in front hides.
CameraScene wall_with_edge() {
  CameraScene scene;
  scene.T_G_base.emplace_back();
  scene.stop_known.push_back(1);
  for (double x = -2.0; x < 2.0; x += 0.04) {
    for (double y = -2.0; y < 2.0; y += 0.04) {
      scene.samples.push_back({Eigen::Vector3d(x, y, 4.0).cast<float>(), -Eigen::Vector3f::UnitZ(), 200, 0});
      if (y > 0.0) {
        scene.samples.push_back(
            {Eigen::Vector3d(0.5 * x, 0.5 * y, 2.0).cast<float>(), -Eigen::Vector3f::UnitZ(), 20, 0});
      }
    }
  }
  for (double y = -1.5; y < 1.5; y += 0.025) {
    LidarEdge edge;
    edge.p_G = {0.0, y, 4.0};
    edge.direction_G = Vector3d::UnitY();
    edge.normal_a_G = Vector3d(1.0, 0.0, -1.0).normalized();
    edge.normal_b_G = Vector3d(-1.0, 0.0, -1.0).normalized();
    scene.edges.push_back(edge);
  }
  return scene;
}

// A pixel of the camera in a picture of its own size.
Rgb colour(const Image& picture, int x, int y) {
  const int row = y + overlay_legend_rows;
  return {static_cast<std::uint8_t>(picture.at(x, row, 0)), static_cast<std::uint8_t>(picture.at(x, row, 1)),
          static_cast<std::uint8_t>(picture.at(x, row, 2))};
}

// Lines fade out over their border.
testing::AssertionResult is_about(const Rgb& rgb, const Rgb& expected) {
  for (std::size_t c = 0; c < 3; ++c) {
    if (std::abs(rgb[c] - expected[c]) > 40)
      return testing::AssertionFailure() << int{rgb[0]} << " " << int{rgb[1]} << " " << int{rgb[2]};
  }
  return testing::AssertionSuccess();
}

constexpr Rgb dimmed{65, 65, 65};  // what a grey value of 100 becomes

TEST(Overlay, DrawsWhatIsSeenOfAnEdgeAtTheGuessAndAtTheResult) {
  const CameraModel model(small_camera());
  const CameraScene scene = wall_with_edge();
  const OverlayPoses poses{SE3{Matrix3d::Identity(), {0.4, 0.0, 0.0}}, SE3{}};
  const Image picture = draw_edges(flat_image(100.0F), model, scene, poses, "camera");
  ASSERT_TRUE(picture.is_consistent());
  EXPECT_EQ(picture.width, 320);
  EXPECT_EQ(picture.height, 240 + overlay_legend_rows);
  for (const int y : {60, 80, 100}) {
    EXPECT_TRUE(is_about(colour(picture, 160, y), result_rgb)) << y;
    EXPECT_TRUE(is_about(colour(picture, 180, y), guess_rgb)) << y;  // 0.4 m at 4 m
    EXPECT_EQ(colour(picture, 170, y), dimmed) << y;
  }
  // Behind the board.
  for (const int y : {140, 160, 180}) {
    EXPECT_EQ(colour(picture, 160, y), dimmed) << y;
    EXPECT_EQ(colour(picture, 180, y), dimmed) << y;
  }
}

TEST(Overlay, DrawsNoGuessWhereThereIsNone) {
  const CameraModel model(small_camera());
  const Image picture = draw_edges(flat_image(100.0F), model, wall_with_edge(), {{}, SE3{}}, "camera");
  for (std::size_t k = 0; k + 2 < picture.bytes.size(); k += 3) {
    ASSERT_FALSE(picture.bytes[k] > 200 && picture.bytes[k + 2] < 50) << "orange at byte " << k;
  }
}

TEST(Overlay, ShowsAPartOfTheImageLarger) {
  const CameraModel model(small_camera());
  GreyImage grey = flat_image(100.0F);
  grey.values[80 * 320 + 150] = 200.0F;
  const OverlayWindow window{140, 60, 40, 30, 4.0};
  const Image picture = draw_edges(grey, model, wall_with_edge(), {{}, SE3{}}, "camera", window);
  EXPECT_EQ(picture.width, 160);
  EXPECT_EQ(picture.height, 120 + overlay_legend_rows);
  EXPECT_EQ(colour(picture, 4 * 10, 4 * 20), (Rgb{129, 129, 129}));
  EXPECT_EQ(colour(picture, 4 * 10 + 3, 4 * 20 + 3), (Rgb{129, 129, 129}));
  EXPECT_EQ(colour(picture, 4 * 10 + 4, 4 * 20), dimmed);
  // The middle of pixel 160 of the camera.
  EXPECT_TRUE(is_about(colour(picture, 82, 60), result_rgb));
  EXPECT_EQ(colour(picture, 76, 60), dimmed);
}

TEST(Overlay, MakesADarkImageBrightEnoughToBeSeen) {
  const CameraModel model(small_camera());
  GreyImage grey = flat_image(10.0F);
  for (int k = 0; k < 320 * 120; ++k) grey.values[static_cast<std::size_t>(k)] = 30.0F;
  const Image picture = draw_edges(grey, model, wall_with_edge(), {}, "camera");
  EXPECT_EQ(colour(picture, 100, 60), (Rgb{165, 165, 165}));
  EXPECT_EQ(colour(picture, 100, 180), (Rgb{0, 0, 0}));
}

TEST(Overlay, IsLeftOutOfThePictureWhereTheWindowLeavesTheImage) {
  const CameraModel model(small_camera());
  const Image picture =
      draw_edges(flat_image(100.0F), model, wall_with_edge(), {{}, SE3{}}, "camera", {300, 220, 40, 40, 1.0});
  ASSERT_TRUE(picture.is_consistent());
  EXPECT_EQ(colour(picture, 10, 10), dimmed);
  EXPECT_EQ(colour(picture, 30, 30), (Rgb{0, 0, 0}));
}

TEST(Overlay, ColoursTheMapByRangeAndByReflectivityWithWhatIsNearOnTop) {
  const CameraModel model(small_camera());
  const CameraScene scene = wall_with_edge();
  const Image range = draw_map(flat_image(100.0F), model, scene, SE3{}, MapColour::range, "camera");
  const auto sum = [](const Rgb& rgb) { return rgb[0] + rgb[1] + rgb[2]; };
  const Rgb wall = colour(range, 160, 60);
  const Rgb board = colour(range, 160, 160);
  EXPECT_GT(wall[1], 200) << "far is yellow";
  EXPECT_LT(board[1], 60) << "near is dark blue";
  const Image reflectivity = draw_map(flat_image(100.0F), model, scene, SE3{}, MapColour::reflectivity, "camera");
  EXPECT_GT(sum(colour(reflectivity, 160, 60)), sum(colour(reflectivity, 160, 160)) + 100);
}

TEST(Overlay, ColoursAFloorToItsFarEnd) {
  const CameraModel model(small_camera());
  CameraScene scene;
  for (double x = -4.0; x < 4.0; x += 0.04) {
    for (double z = 3.0; z < 12.0; z += 0.04)
      scene.samples.push_back({Vector3d(x, 1.0, z).cast<float>(), -Eigen::Vector3f::UnitY(), 100, 0});
  }
  const Image picture = draw_map(flat_image(100.0F), model, scene, SE3{}, MapColour::range, "camera");
  // The floor's far end is in row 120 + 200 / 12.
  for (int y = 139; y < 180; ++y) EXPECT_NE(colour(picture, 160, y), dimmed) << y;
}

// Four stops that look at the wall or, turned by 90 or 180 degrees, at nothing; two images of the first one.
CameraTask four_stops(CameraScene& scene) {
  CameraTask task;
  task.name = "camera";
  task.intrinsics = small_camera();
  scene.T_G_base.clear();
  scene.stop_known.assign(4, 1);
  for (int j = 0; j < 4; ++j) {
    const double turn_deg = std::array{0.0, 90.0, 5.0, 40.0}[static_cast<std::size_t>(j)];
    scene.T_G_base.push_back(SE3{exp_so3(to_rad(turn_deg) * Vector3d::UnitY()), Vector3d::Zero()});
    task.views.push_back({j, "", flat_image(100.0F)});
  }
  task.views.push_back({0, "", flat_image(50.0F)});
  return task;
}

TEST(Overlay, ChoosesViewsWithManyEdgesThatLookInDifferentDirections) {
  CameraScene scene = wall_with_edge();
  CameraTask task = four_stops(scene);
  const CameraModel model(task.intrinsics);
  EXPECT_THAT(choose_views(scene, task, model, SE3{}, 1), ElementsAre(0));
  EXPECT_THAT(choose_views(scene, task, model, SE3{}, 2), ElementsAre(0, 1));
  EXPECT_THAT(choose_views(scene, task, model, SE3{}, 9), ElementsAre(0, 1, 3, 2));
  scene.stop_known[0] = 0;
  EXPECT_THAT(choose_views(scene, task, model, SE3{}, 1), ElementsAre(2));
  task.views[2].grey = {160, 120, std::vector<float>(160 * 120, 100.0F)};  // not this camera's
  EXPECT_THAT(choose_views(scene, task, model, SE3{}, 1), ElementsAre(1));
}

TEST(Overlay, DrawsAsManyPicturesAsTheBudgetAllows) {
  CameraScene scene = wall_with_edge();
  CameraTask task = four_stops(scene);
  CameraEstimate estimate;
  estimate.found = true;
  estimate.intrinsics = task.intrinsics;
  OverlayBudget budget;
  budget.max_width = 160;
  const std::vector<Overlay> overlays = draw_overlays(scene, task, estimate, budget);
  ASSERT_EQ(overlays.size(), 4U);
  EXPECT_EQ(overlays[0].kind, OverlayKind::edges);
  EXPECT_EQ(overlays[1].kind, OverlayKind::map);
  EXPECT_EQ(overlays[2].kind, OverlayKind::edges);
  EXPECT_EQ(overlays[2].stop, 1);
  const auto decoded = decode_image(overlays[0].jpeg, "overlay");
  ASSERT_TRUE(decoded) << decoded.error().message();
  EXPECT_EQ(decoded->width, 160);
  EXPECT_EQ(decoded->height, 120 + overlay_legend_rows);
  // Nothing to draw at: neither a guess nor a result.
  estimate.found = false;
  EXPECT_TRUE(draw_overlays(scene, task, estimate, budget).empty());
  // Not found: the guess alone.
  task.guess_T_base_camera = SE3{};
  EXPECT_EQ(draw_overlays(scene, task, estimate, budget).size(), 3U);
}

}  // namespace
}  // namespace rigcal
