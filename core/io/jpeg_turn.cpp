#include "core/io/jpeg_turn.h"

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include "core/io/jpeg_file.h"

namespace rigcal {
namespace {

constexpr unsigned app1 = 0xE1;
constexpr std::array<std::uint8_t, 6> exif_signature{'E', 'x', 'i', 'f', 0, 0};
constexpr std::size_t orientation_tag = 0x0112;
constexpr std::size_t type_short = 3;
constexpr std::size_t entry_bytes = 12;

// Whole numbers of a TIFF file in its own byte order; none past its end.
class Tiff {
 public:
  explicit Tiff(ByteView bytes) : bytes_(bytes), low_first_(!bytes.empty() && bytes[0] == 'I') {}

  [[nodiscard]] std::optional<std::size_t> at(std::size_t offset, std::size_t size) const {
    if (offset > bytes_.size() || bytes_.size() - offset < size) return std::nullopt;
    std::size_t value = 0;
    for (std::size_t k = 0; k < size; ++k) value = value << 8U | bytes_[offset + (low_first_ ? size - 1 - k : k)];
    return value;
  }

 private:
  ByteView bytes_;
  bool low_first_;
};

int orientation_of(const Tiff& tiff) {
  const auto directory = tiff.at(4, 4);
  if (tiff.at(2, 2) != 42U || !directory) return 1;
  const std::size_t count = tiff.at(*directory, 2).value_or(0);
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t entry = *directory + 2 + k * entry_bytes;
    if (tiff.at(entry, 2) != orientation_tag) continue;
    const std::size_t value = tiff.at(entry + 8, 2).value_or(1);
    return tiff.at(entry + 2, 2) == type_short && value >= 1 && value <= 8 ? static_cast<int>(value) : 1;
  }
  return 1;
}

}  // namespace

int jpeg_orientation(ByteView file) {
  JpegSegments segments(file);
  while (const auto segment = segments.next()) {
    const ByteView data = segment->data;
    const bool is_exif = segment->marker == app1 && data.size() >= exif_signature.size() &&
                         std::equal(exif_signature.begin(), exif_signature.end(), data.begin());
    if (is_exif) return orientation_of(Tiff(data.subspan(exif_signature.size())));
  }
  return 1;
}

Image turned_upright(Image image, int orientation) {
  if (orientation <= 1 || orientation > 8) return image;
  const auto width = static_cast<std::size_t>(image.width);
  const auto height = static_cast<std::size_t>(image.height);
  const std::size_t pixel = image.row_bytes() / width;
  const bool swaps = orientation >= 5;
  Image out = image;
  if (swaps) std::swap(out.width, out.height);
  const auto out_width = static_cast<std::size_t>(out.width);
  const auto out_height = static_cast<std::size_t>(out.height);
  // Where a row or column of what is shown comes from the far end of the stored one.
  const bool from_right = orientation == 2 || orientation == 3 || orientation == 7 || orientation == 8;
  const bool from_below = orientation == 3 || orientation == 4 || orientation == 6 || orientation == 7;
  std::uint8_t* to = out.bytes.data();
  for (std::size_t y = 0; y < out_height; ++y) {
    for (std::size_t x = 0; x < out_width; ++x) {
      std::size_t column = swaps ? y : x;
      std::size_t row = swaps ? x : y;
      if (from_right) column = width - 1 - column;
      if (from_below) row = height - 1 - row;
      to = std::copy_n(image.bytes.data() + (row * width + column) * pixel, pixel, to);
    }
  }
  return out;
}

}  // namespace rigcal
