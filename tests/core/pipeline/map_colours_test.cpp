#include "core/pipeline/map_colours.h"

#include <gtest/gtest.h>

#include "core/camera/sample_blocks.h"
#include "core/records/pixel_format.h"
#include "tests/support/pinhole.h"

namespace rigcal {
namespace {

using Rgb8 = std::array<std::uint8_t, 3>;

Image painted(int width, int height, const Rgb8& rgb, const std::string& format) {
  const auto parsed = parse_pixel_format(format);
  Image image{width, height, parsed->channels(), 8, format, {}};
  image.bytes.resize(image.row_bytes() * static_cast<std::size_t>(height));
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      for (int c = 0; c < image.channels; ++c) {
        const int colour = image.channels == 3 ? c : bayer_colour(parsed->layout, x, y);
        image
            .bytes[static_cast<std::size_t>(y) * image.row_bytes() + static_cast<std::size_t>(x * image.channels + c)] =
            rgb[static_cast<std::size_t>(colour)];
      }
    }
  }
  return image;
}

TEST(ColourPicture, MakesColoursOfAMosaicAndShrinksLargeImages) {
  const ColourPicture mosaic = colour_picture(painted(9, 6, {200, 100, 40}, "BayerGR8"), 8);
  EXPECT_EQ(mosaic.shrink, 2);
  EXPECT_EQ(mosaic.rgb.width, 4);
  for (int c = 0; c < 3; ++c) EXPECT_EQ(mosaic.rgb.at(3, 2, c), (Rgb8{200, 100, 40}[static_cast<std::size_t>(c)]));
  const ColourPicture large = colour_picture(painted(2000, 1000, {7, 8, 9}, "RGB8"), 8);
  EXPECT_EQ(large.shrink, 2);
  EXPECT_EQ(large.rgb.width, 1000);
  EXPECT_EQ(large.rgb.at(999, 499, 2), 9);
}

class ColourMap : public testing::Test {
 protected:
  // A wall 5 m before the cameras, and a board 2 m before them that hides its right half (x > 0).
  ColourMap() {
    for (int i = -40; i < 40; ++i) {
      for (int j = -20; j < 20; ++j) {
        const float x = 0.05F * static_cast<float>(i) + 0.025F;
        const float y = 0.05F * static_cast<float>(j) + 0.025F;
        samples_.push_back({{x, y, 5.025F}, {0.0F, 0.0F, -1.0F}, 9, 0});
        if (x > 0.0F && x < 1.0F) samples_.push_back({{x, y, 2.025F}, {0.0F, 0.0F, -1.0F}, 9, 0});
      }
    }
    blocks_ = blocks_of(samples_, 0.5);
  }

  static CameraModel model() { return CameraModel(pinhole(200, 100, 150.0)); }
  static ColourView view(const Rgb8& rgb, const Vector3d& at) {
    return {model(), SE3{Matrix3d::Identity(), -at}, colour_picture(painted(200, 100, rgb, "RGB8"), 8)};
  }

  std::vector<MapSample> samples_;
  std::vector<SampleBlock> blocks_;
};

TEST_F(ColourMap, ColoursWhatAViewSeesAndLeavesTheRestGrey) {
  const std::vector<ColourView> views{view({200, 100, 40}, Vector3d::Zero())};
  const std::vector<MapPoint> map{{-1.01F, 0.02F, 5.01F, 77, 0},   // seen
                                  {1.01F, 0.02F, 5.01F, 78, 0},    // behind the board
                                  {0.51F, 0.02F, 2.01F, 79, 0},    // the board
                                  {-1.01F, 0.02F, -5.0F, 80, 0}};  // behind the camera
  const auto rgb = colour_map(map, views, samples_, blocks_);
  EXPECT_EQ(rgb[0], (Rgb8{200, 100, 40}));
  EXPECT_EQ(rgb[1], (Rgb8{78, 78, 78}));
  EXPECT_EQ(rgb[2], (Rgb8{200, 100, 40}));
  EXPECT_EQ(rgb[3], (Rgb8{80, 80, 80}));
}

TEST_F(ColourMap, ColoursAFloorToItsFarEnd) {
  std::vector<MapSample> floor;
  std::vector<MapPoint> map;
  for (int i = -10; i < 10; ++i) {
    for (int k = 80; k < 240; ++k) {
      const Eigen::Vector3f p(0.05F * static_cast<float>(i) + 0.025F, 1.0F, 0.05F * static_cast<float>(k) + 0.025F);
      floor.push_back({p, -Eigen::Vector3f::UnitY(), 9, 0});
      map.push_back({p.x(), p.y(), p.z(), 77, 0});
    }
  }
  const std::vector<ColourView> views{view({200, 100, 40}, Vector3d::Zero())};
  const auto rgb = colour_map(map, views, floor, blocks_of(floor, 0.5));
  for (std::size_t i = 0; i < map.size(); ++i) ASSERT_EQ(rgb[i], (Rgb8{200, 100, 40})) << map[i].z << " m away";
}

TEST_F(ColourMap, TakesTheMeanOfViewsButNotOfSaturatedOnes) {
  const std::vector<MapPoint> map{{-1.01F, 0.02F, 5.01F, 77, 0}};
  const Vector3d at(-1.0, 0.0, 0.0);
  const std::vector<ColourView> two{view({100, 50, 20}, at), view({200, 50, 40}, at)};
  EXPECT_EQ(colour_map(map, two, samples_, blocks_)[0], (Rgb8{150, 50, 30}));
  const std::vector<ColourView> glare{view({100, 50, 20}, at), view({255, 255, 255}, at)};
  EXPECT_NEAR(colour_map(map, glare, samples_, blocks_)[0][0], 103, 1);
}

TEST_F(ColourMap, TakesTheNearestThreeOfManyViews) {
  const std::vector<MapPoint> map{{-1.01F, 0.02F, 5.01F, 77, 0}};
  std::vector<ColourView> views;
  for (const double z : {0.0, 2.0, 1.0, 3.0, -1.0}) {
    const auto value = static_cast<std::uint8_t>(50 + 20 * z);
    views.push_back(view({value, value, value}, {-1.0, 0.0, z}));
  }
  // z = 3, 2, 1 at ranges 2, 3, 4.
  const double mean = (110.0 / 2.0 + 90.0 / 3.0 + 70.0 / 4.0) / (1.0 / 2.0 + 1.0 / 3.0 + 1.0 / 4.0);
  EXPECT_NEAR(colour_map(map, views, samples_, blocks_)[0][0], mean, 1.0);
}

TEST_F(ColourMap, TakesEveryCameraThatSeesAPointHoweverManyViewsANearerOneHas) {
  const std::vector<MapPoint> map{{-1.01F, 0.02F, 5.01F, 77, 0}};
  std::vector<ColourView> views(5, view({100, 60, 40}, {-1.0, 0.0, 3.0}));
  views.push_back(view({200, 160, 140}, {-1.0, 0.0, 1.0}));
  EXPECT_EQ(colour_map(map, views, samples_, blocks_)[0], (Rgb8{100, 60, 40}));
  views.back().camera = 1;
  // Three at 2 m and one at 4 m.
  const double mean = (3 * 100.0 / 2.0 + 200.0 / 4.0) / (3 / 2.0 + 1 / 4.0);
  EXPECT_NEAR(colour_map(map, views, samples_, blocks_)[0][0], mean, 1.0);
  // Behind the board only the camera beside it sees the wall.
  const std::vector<MapPoint> hidden{{0.51F, 0.02F, 5.01F, 77, 0}};
  std::vector<ColourView> apart{view({100, 60, 40}, {0.5, 0.0, 0.0}), view({200, 160, 140}, {0.5, 0.0, 2.5})};
  apart.back().camera = 1;
  EXPECT_EQ(colour_map(hidden, apart, samples_, blocks_)[0], (Rgb8{200, 160, 140}));
}

TEST_F(ColourMap, WeighsAViewTheLessTheWorseItIsExposed) {
  const std::vector<MapPoint> map{{-1.01F, 0.02F, 5.01F, 77, 0}};
  const Vector3d at(-1.0, 0.0, 0.0);
  const auto with = [&](std::uint8_t other) {
    return int{colour_map(map, std::vector<ColourView>{view({100, 100, 100}, at), view({other, other, other}, at)},
                          samples_, blocks_)[0][0]};
  };
  EXPECT_EQ(with(200), 150);
  EXPECT_EQ(with(40), 70);
  EXPECT_NEAR(with(240), (100.0 + 0.5 * 240.0) / 1.5, 1.0);  // half way from well exposed to saturated
  EXPECT_NEAR(with(18), (100.0 + 0.5 * 18.0) / 1.5, 1.0);
  EXPECT_NEAR(with(0), 100.0 / 1.02, 1.0);
}

}  // namespace
}  // namespace rigcal
