#include "core/records/pixel_format.h"

#include <gtest/gtest.h>

#include <string>

#include "core/records/image.h"

namespace rigcal {
namespace {

TEST(PixelFormat, ReadsTheNamesThatCamerasUse) {
  EXPECT_EQ(PixelLayout::mono, parse_pixel_format("Mono8")->layout);
  EXPECT_EQ(PixelLayout::bayer_gb, parse_pixel_format("BayerGB12")->layout);
  EXPECT_EQ(12, parse_pixel_format("BayerGB12")->bits);
  EXPECT_EQ(16, parse_pixel_format("BayerGB12")->stored_bits());
  EXPECT_EQ(3, parse_pixel_format("RGB8")->channels());
  EXPECT_EQ(8, parse_pixel_format("")->stored_bits());
  for (const char* name : {"Mono", "Mono9", "Mono12Packed", "BayerRG", "bayerRG8", "YUV422"})
    EXPECT_FALSE(parse_pixel_format(name).has_value()) << name;
}

TEST(PixelFormat, ABayerLayoutBeginsWithTheColoursOfItsName) {
  const std::string letters = "RGB";
  for (const char* name : {"RG", "GR", "GB", "BG"}) {
    const PixelLayout layout = parse_pixel_format(std::string("Bayer") + name + "8")->layout;
    EXPECT_EQ(name[0], letters[static_cast<std::size_t>(bayer_colour(layout, 0, 0))]) << name;
    EXPECT_EQ(name[1], letters[static_cast<std::size_t>(bayer_colour(layout, 1, 0))]) << name;
    // One red, two green and one blue in each square of four, and the same in the next one.
    int count[3] = {0, 0, 0};
    for (int i = 0; i < 4; ++i) {
      ++count[bayer_colour(layout, i % 2, i / 2)];
      EXPECT_EQ(bayer_colour(layout, i % 2, i / 2), bayer_colour(layout, i % 2 + 2, i / 2 + 4));
    }
    EXPECT_EQ(2, count[1]);
    EXPECT_EQ(1, count[0]);
  }
}

TEST(Image, KnowsWhetherItsSizesAgree) {
  Image image{3, 2, 1, 16, "Mono12", std::vector<std::uint8_t>(12)};
  EXPECT_TRUE(image.is_consistent());
  image.bytes[2 * (3 + 2)] = 0x34;
  image.bytes[2 * (3 + 2) + 1] = 0x12;
  EXPECT_EQ(0x1234, image.at(2, 1));
  image.bytes.pop_back();
  EXPECT_FALSE(image.is_consistent());
}

}  // namespace
}  // namespace rigcal
