#include "core/io/image_file.h"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <optional>
#include <string_view>

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
      size = {big_endian(data.first(4)), big_endian(data.subspan(4, 4))};
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

// From the frame header (SOF0 .. SOF15, ITU T.81), found over the segments before it; the end marker must be there, and
// a bit at least for each block of 64 pixels.
std::optional<ImageSize> jpeg_size(ByteView file) {
  constexpr std::array<std::uint8_t, 2> end{0xFF, 0xD9};
  std::size_t at = 2;
  while (at + 9 <= file.size() && file[at] == 0xFF) {
    const unsigned marker = file[at + 1];
    if (marker == 0xFF) {  // fill
      ++at;
      continue;
    }
    const bool is_frame = marker >= 0xC0 && marker <= 0xCF && marker != 0xC4 && marker != 0xC8 && marker != 0xCC;
    if (is_frame) {
      if (std::search(file.begin() + static_cast<std::ptrdiff_t>(at), file.end(), end.begin(), end.end()) == file.end())
        return std::nullopt;
      const ImageSize size{big_endian(file.subspan(at + 7, 2)), big_endian(file.subspan(at + 5, 2))};
      return size.width * size.height / 512 > file.size() ? std::nullopt : std::optional(size);
    }
    at += 2 + big_endian(file.subspan(at + 2, 2));
  }
  return std::nullopt;
}

Error damaged(const std::string& name) {
  return input_error("the image is damaged or cut short", name, "copy it again, or leave it out");
}

// Rows without gaps, red first, without opacity.
Image to_image(const cv::Mat& decoded) {
  Image image;
  image.width = decoded.cols;
  image.height = decoded.rows;
  image.channels = decoded.channels() <= 2 ? 1 : 3;
  image.bits = decoded.depth() == CV_16U ? 16 : 8;
  image.bytes.resize(image.row_bytes() * static_cast<std::size_t>(image.height));
  const std::size_t value = static_cast<std::size_t>(image.bits / 8);
  const auto from_channels = static_cast<std::size_t>(decoded.channels());
  const auto channels = static_cast<std::size_t>(image.channels);
  for (int y = 0; y < image.height; ++y) {
    const std::uint8_t* from = decoded.ptr<std::uint8_t>(y);
    std::uint8_t* to = image.bytes.data() + static_cast<std::size_t>(y) * image.row_bytes();
    for (int x = 0; x < image.width; ++x, from += from_channels * value) {
      for (std::size_t c = 0; c < channels; ++c, to += value)
        std::memcpy(to, from + (channels == 3 ? 2 - c : c) * value, value);
    }
  }
  return image;
}

}  // namespace

Expected<Image> decode_image(ByteView file, const std::string& name) {
  const bool is_png = starts_with(file, png_signature);
  if (!is_png && !starts_with(file, jpeg_signature))
    return input_error("is neither a PNG nor a JPEG image", name, "convert it to PNG");
  const auto size = is_png ? png_size(file) : jpeg_size(file);
  if (!size || size->width == 0 || size->height == 0) return damaged(name);
  if (size->width > max_side || size->height > max_side || size->width * size->height > max_pixels) {
    return input_error("the image is " + std::to_string(size->width) + " x " + std::to_string(size->height) +
                           " pixels large, more than " + std::to_string(max_pixels),
                       name, "check that it is the right file");
  }
  if (file.size() > max_file_bytes) return damaged(name);
  cv::Mat decoded;
  try {
    // The decoder only reads.
    const cv::Mat bytes(1, static_cast<int>(file.size()), CV_8U, const_cast<std::uint8_t*>(file.data()));
    decoded = cv::imdecode(bytes, cv::IMREAD_UNCHANGED | cv::IMREAD_IGNORE_ORIENTATION);
  } catch (const std::exception&) {
    return damaged(name);
  }
  const bool known = (decoded.depth() == CV_8U || decoded.depth() == CV_16U) && decoded.channels() <= 4;
  if (decoded.empty() || !known || static_cast<std::uint64_t>(decoded.cols) != size->width ||
      static_cast<std::uint64_t>(decoded.rows) != size->height)
    return damaged(name);
  return to_image(decoded);
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

Expected<std::vector<std::uint8_t>> encode_jpeg(const Image& image, int quality) {
  if (!image.is_consistent() || image.bits != 8)
    return input_error("an image's size, channels and bytes contradict each other, or it has 16 bits");
  // The encoder only reads, and wants blue first.
  cv::Mat pixels(image.height, image.width, image.channels == 1 ? CV_8UC1 : CV_8UC3,
                 const_cast<std::uint8_t*>(image.bytes.data()));
  if (image.channels == 3) {
    pixels = pixels.clone();
    for (int y = 0; y < pixels.rows; ++y) {
      std::uint8_t* row = pixels.ptr<std::uint8_t>(y);
      for (int x = 0; x < pixels.cols; ++x) std::swap(row[3 * x], row[3 * x + 2]);
    }
  }
  std::vector<std::uint8_t> bytes;
  try {
    if (cv::imencode(".jpg", pixels, bytes, {cv::IMWRITE_JPEG_QUALITY, quality})) return bytes;
  } catch (const std::exception&) {
  }
  return input_error("the image cannot be written as JPEG");
}

}  // namespace rigcal
