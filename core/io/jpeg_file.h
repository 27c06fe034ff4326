#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/base/bytes.h"
#include "core/base/error.h"
#include "core/records/image.h"

namespace rigcal {

/// A segment of a JPEG file's head (ITU T.81, B.1.1): its marker's second byte, and what follows its length.
struct JpegSegment {
  unsigned marker = 0;
  ByteView data;  ///< Lives as long as the file's bytes.
};

/// The segments of a JPEG file before its pixels, one after the other.
class JpegSegments {
 public:
  explicit JpegSegments(ByteView file) : file_(file) {}
  /// Nothing once the pixels begin, or where the file is cut or none.
  [[nodiscard]] std::optional<JpegSegment> next();

 private:
  ByteView file_;
  std::size_t at_ = 2;  ///< Behind the start of the image.
};

/// The pixels of a JPEG file, grey or colour with 8 bits; frames of Motion JPEG, which leave the usual Huffman tables
/// out, too. Nothing for what is damaged, has ink colours (CMYK), or is packed into more passes than any camera makes.
/// The size is that of the file's head: see that it is sane first.
[[nodiscard]] std::optional<Image> decode_jpeg(ByteView file);

/// An 8 bit image as a JPEG file's bytes; `quality` 0 .. 100. Errors (kind input): sizes that contradict each other,
/// 16 bits.
[[nodiscard]] Expected<std::vector<std::uint8_t>> encode_jpeg(const Image& image, int quality);

}  // namespace rigcal
