#include "core/edges/grey_image.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/records/pixel_format.h"

namespace rigcal {
namespace {

Image made(int width, int height, int channels, int bits, const std::string& format) {
  Image image{width, height, channels, bits, format, {}};
  image.bytes.resize(image.row_bytes() * static_cast<std::size_t>(height));
  return image;
}

void set(Image& image, int x, int y, int channel, int value) {
  const std::size_t at =
      static_cast<std::size_t>(y) * image.row_bytes() +
      static_cast<std::size_t>(x * image.channels + channel) * static_cast<std::size_t>(image.bits / 8);
  image.bytes[at] = static_cast<std::uint8_t>(value & 0xFF);
  if (image.bits == 16) image.bytes[at + 1] = static_cast<std::uint8_t>(value >> 8);
}

TEST(GreyImage, HasNoPatternOfTheBayerFilterLeft) {
  for (const char* format : {"BayerRG8", "BayerGR8", "BayerGB8", "BayerBG8"}) {
    Image image = made(9, 8, 1, 8, format);
    const PixelLayout layout = parse_pixel_format(format)->layout;
    constexpr std::array<int, 3> rgb{200, 100, 40};
    for (int y = 0; y < image.height; ++y) {
      for (int x = 0; x < image.width; ++x) {
        set(image, x, y, 0, rgb[static_cast<std::size_t>(bayer_colour(layout, x, y))]);
      }
    }
    const GreyImage grey = to_grey(image, 8);
    for (const float value : grey.values) EXPECT_NEAR(value, 0.25F * 200 + 0.5F * 100 + 0.25F * 40, 1e-3) << format;
  }
}

TEST(GreyImage, LeavesTheEdgeOfAMosaicInItsPlace) {
  Image image = made(20, 6, 1, 8, "BayerGB8");
  for (int y = 0; y < 6; ++y) {
    for (int x = 10; x < 20; ++x) set(image, x, y, 0, 100);
  }
  const GreyImage grey = to_grey(image, 8);
  // Half way up between columns 9 and 10.
  EXPECT_NEAR(0.5F * (grey.at(9, 3) + grey.at(10, 3)), 50.0F, 1e-3);
  EXPECT_FLOAT_EQ(grey.at(8, 3), 0.0F);
  EXPECT_FLOAT_EQ(grey.at(11, 3), 100.0F);
}

TEST(GreyImage, TakesAMonoImageAndAColourImageOfABayerCameraAsTheyAre) {
  Image mono = made(3, 1, 1, 8, "Mono8");
  set(mono, 1, 0, 0, 90);
  EXPECT_FLOAT_EQ(to_grey(mono, 8).at(1, 0), 90.0F);
  EXPECT_FLOAT_EQ(to_grey(mono, 8).at(0, 0), 0.0F);
  Image colour = made(3, 1, 3, 8, "BayerRG8");
  set(colour, 1, 0, 0, 100);
  set(colour, 1, 0, 1, 50);
  set(colour, 1, 0, 2, 200);
  EXPECT_NEAR(to_grey(colour, 8).at(1, 0), 0.299 * 100 + 0.587 * 50 + 0.114 * 200, 1e-3);
  EXPECT_FLOAT_EQ(to_grey(colour, 8).at(0, 0), 0.0F);
}

TEST(GreyImage, KnowsHowManyBitsCarryTheValue) {
  Image image = made(2, 1, 1, 16, "Mono12");
  set(image, 0, 0, 0, 900);
  EXPECT_EQ(value_bits(image), 12);
  image.pixel_format.clear();
  EXPECT_EQ(value_bits(image), 10);
  for (const char* wide : {"Mono16", "BayerRG16", "RGB16"}) {
    image.pixel_format = wide;
    EXPECT_EQ(value_bits(image), 10) << wide;
  }
  image.pixel_format.clear();
  set(image, 0, 0, 0, 4095);
  EXPECT_EQ(value_bits(image), 12);
  EXPECT_FLOAT_EQ(to_grey(image, 12).at(0, 0), 255.0F);
  // Shifted to the left by the driver, whatever the format says.
  set(image, 0, 0, 0, 4095 << 4);
  image.pixel_format = "BayerRG12";
  EXPECT_EQ(value_bits(image), 16);
  EXPECT_EQ(value_bits(made(2, 1, 3, 8, "RGB8")), 8);
}

TEST(GreyImage, TellsHowMuchItShows) {
  GreyImage grey{100, 10, std::vector<float>(1000, 7.0F)};
  EXPECT_FLOAT_EQ(grey_spread(grey), 0.0F);
  grey.values[500] = 255.0F;  // a hot pixel
  EXPECT_FLOAT_EQ(grey_spread(grey), 0.0F);
  std::fill_n(grey.values.begin(), 300, 80.0F);
  EXPECT_FLOAT_EQ(grey_spread(grey), 73.0F);
}

}  // namespace
}  // namespace rigcal
