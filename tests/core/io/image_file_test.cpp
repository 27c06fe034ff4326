#include "core/io/image_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/random.h"
#include "core/io/jpeg_file.h"
#include "tests/support/files.h"
#include "tests/support/scratch_folder.h"

namespace rigcal {
namespace {

using testing::HasSubstr;
using Bytes = std::vector<std::uint8_t>;

Image noise_image(int channels, int bits) {
  Image image;
  image.width = 37;
  image.height = 23;
  image.channels = channels;
  image.bits = bits;
  image.bytes.resize(image.row_bytes() * 23);
  Random random(5);
  for (std::uint8_t& byte : image.bytes) byte = static_cast<std::uint8_t>(random.below(256));
  return image;
}

TEST(ImageFile, ReadsBackWhatItWrote) {
  for (const int channels : {1, 3}) {
    for (const int bits : {8, 16}) {
      const Image image = noise_image(channels, bits);
      const std::string path = fresh_path("round.png");
      ASSERT_TRUE(write_image(path, image).has_value());
      const auto read = read_image(path);
      ASSERT_TRUE(read.has_value()) << read.error().message();
      EXPECT_EQ(37, read->width);
      EXPECT_EQ(23, read->height);
      EXPECT_EQ(channels, read->channels);
      EXPECT_EQ(bits, read->bits);
      EXPECT_TRUE(image.bytes == read->bytes) << channels << " channels of " << bits;
    }
  }
}

// The file shows red, green and blue columns of 8 pixels.
TEST(ImageFile, ReadsAJpegWithRedFirst) {
  const auto image = read_image(std::string(RIGCAL_SOURCE_DIR) + "/tests/fuzz/corpus/image/colours.jpg");
  ASSERT_TRUE(image.has_value()) << image.error().message();
  ASSERT_EQ(24, image->width);
  ASSERT_EQ(3, image->channels);
  for (int c = 0; c < 3; ++c) EXPECT_GT(image->at(8 * c + 4, 4, c), 230) << c;
  EXPECT_LT(image->at(4, 4, 2), 30);
}

Expected<Image> sample(const std::string& name) {
  return read_image(std::string(RIGCAL_SOURCE_DIR) + "/tests/fuzz/corpus/image/" + name);
}

TEST(ImageFile, ReadsEveryKindOfPng) {
  const auto palette = sample("palette.png");  // red, green, blue and another; then backwards
  ASSERT_TRUE(palette.has_value()) << palette.error().message();
  EXPECT_EQ(3, palette->channels);
  EXPECT_EQ((Bytes{255, 0, 0, 0, 255, 0, 0, 0, 255, 9, 8, 7, 9, 8, 7, 0, 0, 255, 0, 255, 0, 255, 0, 0}),
            palette->bytes);
  const auto one_bit = sample("one_bit.png");
  ASSERT_TRUE(one_bit.has_value()) << one_bit.error().message();
  EXPECT_EQ(1, one_bit->channels);
  EXPECT_EQ((Bytes{255, 0, 255, 0, 255, 0, 255, 0, 0, 0, 0, 0, 255, 255, 255, 255}), one_bit->bytes);
  const auto opaque = sample("grey_opaque.png");
  ASSERT_TRUE(opaque.has_value()) << opaque.error().message();
  EXPECT_EQ(1, opaque->channels);
  EXPECT_EQ((Bytes{10, 200}), opaque->bytes);
  const auto interlaced = sample("interlaced.png");
  ASSERT_TRUE(interlaced.has_value()) << interlaced.error().message();
  EXPECT_EQ((Bytes{1, 2, 3, 4}), interlaced->bytes);
}

// The segments up to the image itself, but those of a marker.
Bytes without_segments(const Bytes& jpeg, std::uint8_t marker) {
  const auto place = [&](std::size_t index) { return jpeg.begin() + static_cast<std::ptrdiff_t>(index); };
  Bytes out{jpeg[0], jpeg[1]};
  std::size_t at = 2;
  while (jpeg[at + 1] != 0xDA) {
    const std::size_t size = 2 + (std::size_t{jpeg[at + 2]} << 8U | jpeg[at + 3]);
    if (jpeg[at + 1] != marker) out.insert(out.end(), place(at), place(at + size));
    at += size;
  }
  out.insert(out.end(), place(at), jpeg.end());
  return out;
}

// As webcams send it: without the Huffman tables, which every decoder of Motion JPEG knows.
TEST(ImageFile, ReadsMotionJpeg) {
  const auto jpeg = encode_jpeg(noise_image(3, 8), 90);
  ASSERT_TRUE(jpeg) << jpeg.error().message();
  const Bytes bare = without_segments(*jpeg, 0xC4);
  ASSERT_LT(bare.size(), jpeg->size() - 300);
  const auto motion = decode_image(bare, "frame");
  ASSERT_TRUE(motion.has_value()) << motion.error().message();
  EXPECT_EQ(decode_image(*jpeg, "whole")->bytes, motion->bytes);
}

TEST(ImageFile, ReadsProgressiveJpegOfAsManyPassesAsOneNeeds) {
  const auto progressive = sample("progressive.jpg");
  ASSERT_TRUE(progressive.has_value()) << progressive.error().message();
  EXPECT_NEAR(16 * 9, progressive->at(9, 5), 3);
  EXPECT_FALSE(sample("many_scans.jpg").has_value()) << "each is work for all pixels";
}

TEST(ImageFile, RefusesInkColours) {
  EXPECT_THAT(sample("four_inks.jpg").error().message(), HasSubstr("four_inks.jpg: the image has colours of ink"));
}

TEST(ImageFile, RefusesWhatIsCutOrChangedAnywhere) {
  const std::string path = fresh_path("damage.png");
  ASSERT_TRUE(write_image(path, noise_image(3, 16)).has_value());
  const Bytes whole = read_bytes(path);
  ASSERT_TRUE(decode_image(whole, "f").has_value());
  for (std::size_t size = 0; size < whole.size(); size += size < 64 ? 1 : 37) {
    const auto cut = decode_image({whole.data(), size}, "cut.png");
    ASSERT_FALSE(cut.has_value()) << size;
    ASSERT_THAT(cut.error().message(), HasSubstr("cut.png: "));
  }
  for (std::size_t at = 0; at < whole.size(); at += at < 64 ? 1 : 53) {
    Bytes changed = whole;
    changed[at] ^= 0x10U;
    EXPECT_FALSE(decode_image(changed, "f").has_value()) << at;
  }
  const Bytes jpeg = read_bytes(std::string(RIGCAL_SOURCE_DIR) + "/tests/fuzz/corpus/image/colours.jpg");
  for (std::size_t size = 0; size + 2 < jpeg.size(); size += 11)
    EXPECT_FALSE(decode_image({jpeg.data(), size}, "f").has_value()) << size;
}

// Width and height of 60000 in the header, its sum made right again: 3.6 billion pixels in a hundred bytes; and a size
// within the bounds for which the data cannot be enough.
TEST(ImageFile, RefusesASizeThatItCannotHave) {
  Image one;
  one.width = 1;
  one.height = 1;
  one.bytes = {7};
  const std::string path = fresh_path("bomb.png");
  ASSERT_TRUE(write_image(path, one).has_value());
  const auto forged = [&](std::uint32_t side, std::uint32_t sum) {
    Bytes bytes = read_bytes(path);
    for (const std::size_t at : {16U, 20U})
      for (std::size_t i = 0; i < 4; ++i) bytes[at + i] = static_cast<std::uint8_t>(side >> (24 - 8 * i));
    for (std::size_t i = 0; i < 4; ++i) bytes[29 + i] = static_cast<std::uint8_t>(sum >> (24 - 8 * i));
    return decode_image(bytes, "bomb.png");
  };
  EXPECT_THAT(forged(60000, 0xA5B92A9E).error().message(), HasSubstr("damaged"));
  EXPECT_THAT(forged(10000, 0x9F253DFB).error().message(), HasSubstr("damaged"));
  EXPECT_FALSE(write_image(fresh_path("odd.png"), Image{4, 4, 1, 8, "", Bytes(15)}).has_value());
}

TEST(ImageFile, SaysWhatIsNoImage) {
  EXPECT_THAT(read_image(fresh_path("missing.png")).error().message(), HasSubstr("no such file"));
  const Bytes text{'h', 'e', 'l', 'l', 'o'};
  EXPECT_THAT(decode_image(text, "x.png").error().message(), HasSubstr("neither a PNG nor a JPEG"));
}

TEST(ImageFile, EncodesJpegInItsColours) {
  Image image;
  image.width = 32;
  image.height = 16;
  image.channels = 3;
  for (int k = 0; k < 32 * 16; ++k) image.bytes.insert(image.bytes.end(), {200, 100, 20});
  const auto bytes = encode_jpeg(image, 95);
  ASSERT_TRUE(bytes) << bytes.error().message();
  const auto read = decode_image(*bytes, "memory");
  ASSERT_TRUE(read) << read.error().message();
  ASSERT_EQ(read->width, 32);
  ASSERT_EQ(read->channels, 3);
  EXPECT_NEAR(read->at(10, 8, 0), 200, 4);
  EXPECT_NEAR(read->at(10, 8, 1), 100, 4);
  EXPECT_NEAR(read->at(10, 8, 2), 20, 4);
  image.bits = 16;
  image.bytes.resize(2 * image.bytes.size());
  EXPECT_FALSE(encode_jpeg(image, 95));
  image.bits = 8;
  EXPECT_FALSE(encode_jpeg(image, 95)) << "too many bytes for its size";
}

}  // namespace
}  // namespace rigcal
