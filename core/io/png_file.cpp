#include "core/io/png_file.h"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <bit>
#include <string_view>
#include <vector>

#include "core/io/output_file.h"

// Portable Network Graphics, W3C Recommendation, second edition.
namespace rigcal {
namespace {

constexpr std::uint32_t largest_side = 65535;

void put_big(std::vector<std::uint8_t>& out, std::uint32_t value) {
  for (int shift = 24; shift >= 0; shift -= 8) out.push_back(static_cast<std::uint8_t>(value >> shift));
}

void write_part(OutputFile& file, std::string_view name, const std::vector<std::uint8_t>& data) {
  std::vector<std::uint8_t> head;
  put_big(head, static_cast<std::uint32_t>(data.size()));
  head.insert(head.end(), name.begin(), name.end());
  uLong sum = crc32(0, head.data() + 4, 4);
  if (!data.empty()) sum = crc32_z(sum, data.data(), data.size());  // of no data zlib gives the start value
  std::vector<std::uint8_t> tail;
  put_big(tail, static_cast<std::uint32_t>(sum));
  file.write(ByteView(head));
  file.write(ByteView(data));
  file.write(ByteView(tail));
}

/// One row as PNG has it: red first, the high byte first, and the number of its filter (0, none) in front.
void append_row(const PixelView& pixels, std::uint32_t row, std::vector<std::uint8_t>& out) {
  out.push_back(0);
  const std::size_t value_bytes = pixels.bits == 16 ? 2 : 1;
  const auto channels = static_cast<std::size_t>(pixels.channels);
  const std::uint8_t* at = pixels.data.data() + row * pixels.step;
  for (std::uint32_t column = 0; column < pixels.width; ++column, at += channels * value_bytes) {
    for (std::size_t c = 0; c < channels; ++c) {
      const std::size_t from = pixels.blue_first && c < 3 ? 2 - c : c;
      const std::uint8_t* value = at + from * value_bytes;
      if (value_bytes == 1) {
        out.push_back(*value);
      } else {
        out.push_back(value[pixels.big_endian ? 0 : 1]);
        out.push_back(value[pixels.big_endian ? 1 : 0]);
      }
    }
  }
}

}  // namespace

Expected<void> write_png(const std::string& path, const PixelView& pixels) {
  const bool known = (pixels.channels == 1 || ((pixels.channels == 3 || pixels.channels == 4))) &&
                     (pixels.bits == 8 || pixels.bits == 16) && !(pixels.blue_first && pixels.channels == 1);
  const std::uint64_t row_bytes =
      std::uint64_t{pixels.width} * static_cast<std::uint64_t>(pixels.channels * pixels.bits / 8);
  if (!known || pixels.width == 0 || pixels.height == 0 || pixels.width > largest_side ||
      pixels.height > largest_side || pixels.step < row_bytes ||
      (pixels.height - 1) * std::uint64_t{pixels.step} + row_bytes > pixels.data.size()) {
    return input_error("an image's size, channels and bytes contradict each other", path);
  }
  std::vector<std::uint8_t> rows;
  rows.reserve(pixels.height * (row_bytes + 1));
  for (std::uint32_t row = 0; row < pixels.height; ++row) append_row(pixels, row, rows);
  uLongf packed_bytes = compressBound(rows.size());
  std::vector<std::uint8_t> packed(packed_bytes);
  if (compress2(packed.data(), &packed_bytes, rows.data(), rows.size(), Z_BEST_SPEED) != Z_OK) {
    return system_error("no memory to compress an image", path, "use a machine with more");
  }
  packed.resize(packed_bytes);

  Expected<OutputFile> file = OutputFile::create(path);
  if (!file) return file.error();
  file->write(std::string_view("\x89PNG\r\n\x1A\n", 8));
  std::vector<std::uint8_t> head;
  put_big(head, pixels.width);
  put_big(head, pixels.height);
  const std::uint8_t colour_type = pixels.channels == 1 ? 0 : (pixels.channels == 3 ? 2 : 6);
  for (const std::uint8_t byte : {static_cast<std::uint8_t>(pixels.bits), colour_type}) head.push_back(byte);
  head.insert(head.end(), 3, 0);  // deflate, the usual filters, not interlaced
  write_part(*file, "IHDR", head);
  write_part(*file, "IDAT", packed);
  write_part(*file, "IEND", {});
  return file->close();
}

}  // namespace rigcal
