#include "core/io/jpeg_turn.h"

#include <gtest/gtest.h>

#include "core/io/image_file.h"
#include "tests/support/files.h"

namespace rigcal {
namespace {

using Bytes = std::vector<std::uint8_t>;

void append_number(Bytes& bytes, bool low_first, std::size_t size, unsigned value) {
  for (std::size_t k = 0; k < size; ++k)
    bytes.push_back(static_cast<std::uint8_t>(value >> 8U * (low_first ? k : size - 1 - k)));
}

// A segment APP1 of EXIF data: a directory of two entries, the width and the orientation.
Bytes exif_segment(unsigned orientation, bool low_first) {
  Bytes data{'E', 'x', 'i', 'f', 0, 0};
  data.insert(data.end(), 2, low_first ? 'I' : 'M');
  append_number(data, low_first, 2, 42);
  append_number(data, low_first, 4, 8);
  append_number(data, low_first, 2, 2);
  for (const auto& [tag, value] : {std::pair(0x0100U, 640U), std::pair(0x0112U, orientation)}) {
    append_number(data, low_first, 2, tag);
    append_number(data, low_first, 2, 3);
    append_number(data, low_first, 4, 1);
    append_number(data, low_first, 2, value);
    append_number(data, low_first, 2, 0);
  }
  append_number(data, low_first, 4, 0);
  Bytes segment{0xFF, 0xE1};
  append_number(segment, false, 2, static_cast<unsigned>(data.size() + 2));
  segment.insert(segment.end(), data.begin(), data.end());
  return segment;
}

Bytes colours_jpg() { return read_bytes(std::string(RIGCAL_SOURCE_DIR) + "/tests/fuzz/corpus/image/colours.jpg"); }

// Behind the start and the segment that is there already.
Bytes with_segment(const Bytes& jpeg, const Bytes& segment) {
  Bytes out = jpeg;
  const std::size_t first = 2 + 2 + (std::size_t{jpeg[4]} << 8U | jpeg[5]);
  out.insert(out.begin() + static_cast<std::ptrdiff_t>(first), segment.begin(), segment.end());
  return out;
}

TEST(TurnedUpright, IsAsTheStandardShowsEachOrientation) {
  // Rows 1 2 3 and 4 5 6, as they are shown.
  const std::vector<Bytes> shown{{1, 2, 3, 4, 5, 6}, {3, 2, 1, 6, 5, 4}, {6, 5, 4, 3, 2, 1}, {4, 5, 6, 1, 2, 3},
                                 {1, 4, 2, 5, 3, 6}, {4, 1, 5, 2, 6, 3}, {6, 3, 5, 2, 4, 1}, {3, 6, 2, 5, 1, 4}};
  const Image stored{3, 2, 1, 8, "", {1, 2, 3, 4, 5, 6}};
  for (int orientation = 1; orientation <= 8; ++orientation) {
    const Image image = turned_upright(stored, orientation);
    EXPECT_EQ(image.bytes, shown[static_cast<std::size_t>(orientation - 1)]) << orientation;
    EXPECT_EQ(image.width, orientation < 5 ? 3 : 2);
    EXPECT_TRUE(image.is_consistent());
  }
  // Pixels of several bytes stay whole.
  const Image wide{2, 1, 3, 8, "", {1, 2, 3, 4, 5, 6}};
  EXPECT_EQ(turned_upright(wide, 3).bytes, (Bytes{4, 5, 6, 1, 2, 3}));
  EXPECT_EQ(turned_upright(wide, 0).bytes, wide.bytes);
  EXPECT_EQ(turned_upright(wide, 9).bytes, wide.bytes);
}

TEST(JpegOrientation, IsReadInEitherByteOrder) {
  const Bytes jpeg = colours_jpg();
  EXPECT_EQ(jpeg_orientation(jpeg), 1);
  for (const bool low_first : {false, true}) {
    for (unsigned orientation = 1; orientation <= 8; ++orientation) {
      const Bytes turned = with_segment(jpeg, exif_segment(orientation, low_first));
      EXPECT_EQ(jpeg_orientation(turned), static_cast<int>(orientation));
      const auto image = decode_image(turned, "turned");
      ASSERT_TRUE(image) << image.error().message();
      const Image shown = turned_upright(*decode_image(jpeg, "stored"), static_cast<int>(orientation));
      EXPECT_EQ(image->width, shown.width);
      EXPECT_EQ(image->bytes, shown.bytes);
    }
  }
}

TEST(JpegOrientation, OfNonsenseIsNone) {
  const Bytes jpeg = colours_jpg();
  for (const unsigned orientation : {0U, 9U, 600U})
    EXPECT_EQ(jpeg_orientation(with_segment(jpeg, exif_segment(orientation, true))), 1);
  const Bytes segment = exif_segment(6, true);
  // Cut anywhere, or with a length of its own that is wrong.
  for (std::size_t size = 4; size + 12 < segment.size(); ++size) {
    Bytes cut(segment.begin(), segment.begin() + static_cast<std::ptrdiff_t>(size));
    cut[2] = 0;
    cut[3] = static_cast<std::uint8_t>(size - 2);
    EXPECT_EQ(jpeg_orientation(with_segment(jpeg, cut)), 1) << size;
  }
  const Bytes turned = with_segment(jpeg, segment);
  for (std::size_t size = 0; size < 40; ++size) EXPECT_EQ(jpeg_orientation({turned.data(), size}), 1) << size;
}

}  // namespace
}  // namespace rigcal
