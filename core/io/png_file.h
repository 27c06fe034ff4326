#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/base/bytes.h"
#include "core/base/error.h"
#include "core/records/image.h"

namespace rigcal {

/// Pixels in memory, rows from the top, as cameras and messages hold them.
struct PixelView {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  int channels = 1;  ///< 1 grey (also Bayer), 3 colour, 4 colour and opacity.
  int bits = 8;      ///< Of a channel: 8 or 16.
  bool blue_first = false;
  bool big_endian = false;  ///< Of 16 bits.
  std::size_t step = 0;     ///< Bytes from row to row.
  ByteView data;
};

/// A PNG file's bytes, without loss. An Error for a size that contradicts itself (kind input), or no memory (system).
[[nodiscard]] Expected<std::vector<std::uint8_t>> encode_png(const PixelView& pixels);
/// Writes a PNG file without loss: the values read back as they were. Errors: a size that contradicts itself (kind
/// input), the disk (kind system).
Expected<void> write_png(const std::string& path, const PixelView& pixels);

/// The pixels of a PNG file as they are, 8 or 16 bits, grey or colour (a palette's are colour), without opacity.
/// Nothing for what is damaged. The size is that of the file's head: see that it is sane first.
[[nodiscard]] std::optional<Image> decode_png(ByteView file);

}  // namespace rigcal
