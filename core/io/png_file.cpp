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

void append_part(std::string_view name, const std::vector<std::uint8_t>& data, std::vector<std::uint8_t>& file) {
  put_big(file, static_cast<std::uint32_t>(data.size()));
  const std::size_t begin = file.size();
  file.insert(file.end(), name.begin(), name.end());
  file.insert(file.end(), data.begin(), data.end());
  put_big(file, static_cast<std::uint32_t>(crc32_z(0, file.data() + begin, file.size() - begin)));
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

Expected<std::vector<std::uint8_t>> encode_png(const PixelView& pixels) {
  const bool known = (pixels.channels == 1 || ((pixels.channels == 3 || pixels.channels == 4))) &&
                     (pixels.bits == 8 || pixels.bits == 16) && !(pixels.blue_first && pixels.channels == 1);
  const std::uint64_t row_bytes =
      std::uint64_t{pixels.width} * static_cast<std::uint64_t>(pixels.channels * pixels.bits / 8);
  if (!known || pixels.width == 0 || pixels.height == 0 || pixels.width > largest_side ||
      pixels.height > largest_side || pixels.step < row_bytes ||
      (pixels.height - 1) * std::uint64_t{pixels.step} + row_bytes > pixels.data.size()) {
    return input_error("an image's size, channels and bytes contradict each other");
  }
  std::vector<std::uint8_t> rows;
  rows.reserve(pixels.height * (row_bytes + 1));
  for (std::uint32_t row = 0; row < pixels.height; ++row) append_row(pixels, row, rows);
  uLongf packed_bytes = compressBound(rows.size());
  std::vector<std::uint8_t> packed(packed_bytes);
  if (compress2(packed.data(), &packed_bytes, rows.data(), rows.size(), Z_BEST_SPEED) != Z_OK) {
    return system_error("no memory to compress an image", "a PNG image", "use a machine with more");
  }
  packed.resize(packed_bytes);

  std::vector<std::uint8_t> file{0x89, 'P', 'N', 'G', '\r', '\n', 0x1A, '\n'};
  std::vector<std::uint8_t> head;
  put_big(head, pixels.width);
  put_big(head, pixels.height);
  const std::uint8_t colour_type = pixels.channels == 1 ? 0 : (pixels.channels == 3 ? 2 : 6);
  for (const std::uint8_t byte : {static_cast<std::uint8_t>(pixels.bits), colour_type}) head.push_back(byte);
  head.insert(head.end(), 3, 0);  // deflate, the usual filters, not interlaced
  append_part("IHDR", head, file);
  append_part("IDAT", packed, file);
  append_part("IEND", {}, file);
  return file;
}

Expected<void> write_png(const std::string& path, const PixelView& pixels) {
  const Expected<std::vector<std::uint8_t>> bytes = encode_png(pixels);
  if (!bytes) return Error{bytes.error().kind, bytes.error().what, path, bytes.error().mend};
  Expected<OutputFile> file = OutputFile::create(path);
  if (!file) return file.error();
  file->write(ByteView(*bytes));
  return file->close();
}

}  // namespace rigcal
