#include "core/io/image_file.h"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <limits>
#include <optional>
#include <string_view>
#include <utility>

#include "core/io/jpeg_file.h"
#include "core/io/jpeg_turn.h"
#include "core/io/png_file.h"
#include "core/rig/text_file.h"

namespace rigcal {
namespace {

constexpr std::size_t max_file_bytes = std::size_t{1} << 30U;
constexpr std::uint64_t max_side = 65535;
constexpr std::uint64_t max_pixels = 100'000'000;

constexpr std::array<std::uint8_t, 8> png_signature{0x89, 'P', 'N', 'G', '\r', '\n', 0x1A, '\n'};
constexpr std::array<std::uint8_t, 3> jpeg_signature{0xFF, 0xD8, 0xFF};

struct ImageSize {
  std::uint64_t width = 0;
  std::uint64_t height = 0;
  bool is_ink = false;  ///< Four colours of ink (CMYK), as for print.
};

template <std::size_t size>
bool starts_with(ByteView file, const std::array<std::uint8_t, size>& signature) {
  return file.size() >= size && std::equal(signature.begin(), signature.end(), file.begin());
}

std::uint64_t big_endian(ByteView bytes) {
  std::uint64_t value = 0;
  for (const std::uint8_t byte : bytes) value = value << 8U | byte;
  return value;
}

// Walks over all chunks (PNG, second edition, clause 5): whole, with the right sums, from IHDR over IDAT to IEND. The
// data that is there must be enough for the size: deflate packs 1032 bytes into one at best.
std::optional<ImageSize> png_size(ByteView file) {
  ImageSize size;
  std::uint64_t unpacked = 0;
  std::uint64_t packed = 0;
  ByteView rest = file.subspan(png_signature.size());
  while (rest.size() >= 12) {
    const std::uint64_t length = big_endian(rest.first(4));
    if (length > rest.size() - 12) return std::nullopt;
    const ByteView chunk = rest.subspan(4, 4 + length);
    const ByteView data = chunk.subspan(4);
    const std::string_view type(reinterpret_cast<const char*>(chunk.data()), 4);
    if (crc32_z(0, chunk.data(), chunk.size()) != big_endian(rest.subspan(8 + length, 4))) return std::nullopt;
    rest = rest.subspan(12 + length);
    if ((size.width == 0) != (type == "IHDR")) return std::nullopt;
    if (type == "IHDR") {
      if (length != 13) return std::nullopt;
      size = {big_endian(data.first(4)), big_endian(data.subspan(4, 4)), false};
      const std::uint64_t channels = (data[9] & 2U) == 0 || data[9] == 3 ? 1 : 3;
      if (size.width > 0 && size.height > std::numeric_limits<std::uint64_t>::max() / 64 / size.width)
        return std::nullopt;
      unpacked = size.width * size.height * channels * data[8] / 8;
    } else if (type == "IDAT") {
      packed += length;
    } else if (type == "IEND") {
      if (packed == 0 || packed * 1040 < unpacked) return std::nullopt;
      return size;
    }
  }
  return std::nullopt;
}

// From the frame header (SOF0 .. SOF15, ITU T.81); the end marker must be there behind it, and a bit at least for each
// block of 64 pixels.
std::optional<ImageSize> jpeg_size(ByteView file) {
  constexpr std::array<std::uint8_t, 2> end{0xFF, 0xD9};
  JpegSegments segments(file);
  while (const auto segment = segments.next()) {
    const unsigned marker = segment->marker;
    const bool is_frame = marker >= 0xC0 && marker <= 0xCF && marker != 0xC4 && marker != 0xC8 && marker != 0xCC;
    if (!is_frame) continue;
    const ByteView head = segment->data;
    if (head.size() < 6) return std::nullopt;
    const ByteView rest = file.subspan(static_cast<std::size_t>(head.data() - file.data()));
    if (std::search(rest.begin(), rest.end(), end.begin(), end.end()) == rest.end()) return std::nullopt;
    const ImageSize size{big_endian(head.subspan(3, 2)), big_endian(head.subspan(1, 2)), head[5] == 4};
    return size.width * size.height / 512 > file.size() ? std::nullopt : std::optional(size);
  }
  return std::nullopt;
}

Error damaged(const std::string& name) {
  return input_error("the image is damaged or cut short", name, "copy it again, or leave it out");
}

}  // namespace

Expected<Image> decode_image(ByteView file, const std::string& name) {
  const bool is_png = starts_with(file, png_signature);
  if (!is_png && !starts_with(file, jpeg_signature))
    return input_error("is neither a PNG nor a JPEG image", name, "convert it to PNG");
  const auto size = is_png ? png_size(file) : jpeg_size(file);
  if (!size || size->width == 0 || size->height == 0) return damaged(name);
  if (size->is_ink) return input_error("the image has colours of ink (CMYK)", name, "convert it to PNG");
  if (size->width > max_side || size->height > max_side || size->width * size->height > max_pixels) {
    return input_error("the image is " + std::to_string(size->width) + " x " + std::to_string(size->height) +
                           " pixels large, more than " + std::to_string(max_pixels),
                       name, "check that it is the right file");
  }
  if (file.size() > max_file_bytes) return damaged(name);
  std::optional<Image> image = is_png ? decode_png(file) : decode_jpeg(file);
  const auto side = [](int pixels) { return static_cast<std::uint64_t>(pixels); };
  if (!image || side(image->width) != size->width || side(image->height) != size->height) return damaged(name);
  if (!is_png) return turned_upright(std::move(*image), jpeg_orientation(file));
  return std::move(*image);
}

Expected<Image> read_image(const std::string& path) {
  const Expected<std::string> file = read_text_file(path, max_file_bytes);
  if (!file) return file.error();
  return decode_image({reinterpret_cast<const std::uint8_t*>(file->data()), file->size()}, path);
}

Expected<void> write_image(const std::string& path, const Image& image) {
  if (!image.is_consistent()) return input_error("an image's size, channels and bytes contradict each other", path);
  PixelView pixels;
  pixels.width = static_cast<std::uint32_t>(image.width);
  pixels.height = static_cast<std::uint32_t>(image.height);
  pixels.channels = image.channels;
  pixels.bits = image.bits;
  pixels.step = image.row_bytes();
  pixels.data = image.bytes;
  return write_png(path, pixels);
}

}  // namespace rigcal
