#include "core/report/dot_picture.h"

#include <gtest/gtest.h>

#include <limits>

#include "core/io/image_file.h"

namespace rigcal {
namespace {

using Rgb = std::array<int, 3>;

Rgb pixel(const Image& image, int x, int y) {
  const std::uint8_t* at = image.bytes.data() + static_cast<std::size_t>(y) * image.row_bytes() + 3 * x;
  return {at[0], at[1], at[2]};
}

Image decoded(const DotPicture& picture) {
  Expected<Image> image = decode_image(picture.png(), "picture");
  EXPECT_TRUE(image) << image.error().message();
  return *image;
}

TEST(DotPicture, ShowsColoursBrighterWhereThereAreMoreAndMixesThem) {
  DotPicture picture(40, 20);
  picture.dot(5.0, 5.0, {200, 0, 0});
  for (int k = 0; k < 20; ++k) picture.dot(15.0, 5.0, {200, 0, 0});
  picture.dot(25.0, 5.0, {200, 0, 0});
  picture.dot(25.0, 5.0, {0, 200, 0});
  const Image image = decoded(picture);
  ASSERT_EQ(image.width, 40);
  ASSERT_EQ(image.height, 20);
  const Rgb ground = pixel(image, 35, 15);
  const Rgb one = pixel(image, 5, 5);
  const Rgb many = pixel(image, 15, 5);
  const Rgb mixed = pixel(image, 25, 5);
  EXPECT_EQ(pixel(image, 4, 4), one);
  EXPECT_EQ(pixel(image, 6, 5), ground);
  EXPECT_GT(one[0], 100);
  EXPECT_LT(one[1], ground[1]);
  EXPECT_GT(many[0], one[0]);
  EXPECT_LE(many[0], 200);
  EXPECT_NEAR(mixed[0], mixed[1], 5);
  EXPECT_GT(mixed[0], ground[0] + 20);
}

TEST(DotPicture, LeavesOutWhatIsOutside) {
  DotPicture picture(10, 10);
  for (const double away : {-1e300, -2.0, 12.0, 1e300, std::numeric_limits<double>::quiet_NaN()}) {
    picture.dot(away, 5.0, {255, 255, 255});
    picture.dot(5.0, away, {255, 255, 255});
  }
  const Image image = decoded(picture);
  for (int y = 0; y < 10; ++y) {
    for (int x = 0; x < 10; ++x) EXPECT_EQ(pixel(image, x, y), pixel(image, 0, 0));
  }
}

}  // namespace
}  // namespace rigcal
