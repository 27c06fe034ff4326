#include "core/io/png_file.h"

#include <gmock/gmock.h>
#include <zlib.h>

#include "tests/core/io/dump_bytes.h"

namespace rigcal {
namespace {

using testing::ElementsAre;

/// Reads the parts of a PNG file back: checks every checksum, unpacks the rows.
struct PngBytes {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  int bits = 0;
  int colour_type = 0;
  Bytes rows;  ///< With the filter byte in front of each.
};

PngBytes read_back(const std::string& path) {
  const Bytes bytes = read_bytes(path);
  const auto word = [&](std::size_t at) {
    return (std::uint32_t{bytes[at]} << 24U) | (std::uint32_t{bytes[at + 1]} << 16U) |
           (std::uint32_t{bytes[at + 2]} << 8U) | bytes[at + 3];
  };
  PngBytes png;
  EXPECT_EQ(std::string(bytes.begin() + 1, bytes.begin() + 4), "PNG");
  std::string names;
  for (std::size_t at = 8; at + 12 <= bytes.size();) {
    const std::uint32_t size = word(at);
    const std::string name(bytes.begin() + static_cast<std::ptrdiff_t>(at + 4),
                           bytes.begin() + static_cast<std::ptrdiff_t>(at + 8));
    EXPECT_EQ(crc32(0, bytes.data() + at + 4, size + 4), word(at + 8 + size)) << name;
    if (name == "IHDR") {
      png.width = word(at + 8);
      png.height = word(at + 12);
      png.bits = bytes[at + 16];
      png.colour_type = bytes[at + 17];
    }
    if (name == "IDAT") {
      uLongf room = 100'000;
      png.rows.resize(room);
      EXPECT_EQ(uncompress(png.rows.data(), &room, bytes.data() + at + 8, size), Z_OK);
      png.rows.resize(room);
    }
    names += name + " ";
    at += 12 + size;
  }
  EXPECT_EQ(names, "IHDR IDAT IEND ");
  return png;
}

TEST(PngFile, KeepsGreyOfEightBitsWithoutThePadding) {
  const Bytes data{1, 2, 3, 99, 4, 5, 6, 99};
  const std::string path = fresh_path("grey.png");
  ASSERT_TRUE(write_png(path, {3, 2, 1, 8, false, false, 4, data}).has_value());
  const PngBytes png = read_back(path);
  EXPECT_EQ(png.width, 3U);
  EXPECT_EQ(png.height, 2U);
  EXPECT_EQ(png.bits, 8);
  EXPECT_EQ(png.colour_type, 0);
  EXPECT_THAT(png.rows, ElementsAre(0, 1, 2, 3, 0, 4, 5, 6));
}

TEST(PngFile, TurnsColoursAndBytesAsPngWantsThem) {
  const Bytes colours{1, 2, 3, 4, 5, 6};
  const std::string path = fresh_path("colour.png");
  ASSERT_TRUE(write_png(path, {2, 1, 3, 8, true, false, 6, colours}).has_value());
  EXPECT_THAT(read_back(path).rows, ElementsAre(0, 3, 2, 1, 6, 5, 4));
  ASSERT_TRUE(write_png(path, {3, 1, 1, 16, false, false, 6, colours}).has_value());
  EXPECT_THAT(read_back(path).rows, ElementsAre(0, 2, 1, 4, 3, 6, 5));
  ASSERT_TRUE(write_png(path, {3, 1, 1, 16, false, true, 6, colours}).has_value());
  EXPECT_THAT(read_back(path).rows, ElementsAre(0, 1, 2, 3, 4, 5, 6));
  EXPECT_EQ(read_back(path).bits, 16);
  const Bytes opaque{1, 2, 3, 4};
  ASSERT_TRUE(write_png(path, {1, 1, 4, 8, true, false, 4, opaque}).has_value());
  EXPECT_THAT(read_back(path).rows, ElementsAre(0, 3, 2, 1, 4)) << "opacity stays last";
}

TEST(PngFile, RefusesSizesThatContradictThemselves) {
  const Bytes data(8);
  const auto refused = [&](const PixelView& pixels) { return !write_png(fresh_path("no.png"), pixels).has_value(); };
  EXPECT_TRUE(refused({3, 3, 1, 8, false, false, 3, data}));
  EXPECT_TRUE(refused({4, 2, 1, 8, false, false, 3, data}));
  EXPECT_TRUE(refused({0, 2, 1, 8, false, false, 3, data}));
  EXPECT_TRUE(refused({2, 2, 2, 8, false, false, 4, data}));
  EXPECT_TRUE(refused({2, 2, 1, 12, false, false, 4, data}));
  EXPECT_TRUE(refused({0xFFFFFFFF, 0xFFFFFFFF, 4, 16, false, false, 0xFFFFFFFF, data}));
  EXPECT_FALSE(refused({4, 2, 1, 8, false, false, 4, data}));
}

}  // namespace
}  // namespace rigcal
