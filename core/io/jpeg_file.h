#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/base/bytes.h"
#include "core/base/error.h"
#include "core/records/image.h"

namespace rigcal {

/// The pixels of a JPEG file, grey or colour with 8 bits; frames of Motion JPEG, which leave the usual Huffman tables
/// out, too. Nothing for what is damaged, has ink colours (CMYK), or is packed into more passes than any camera makes.
/// The size is that of the file's head: see that it is sane first.
[[nodiscard]] std::optional<Image> decode_jpeg(ByteView file);

/// An 8 bit image as a JPEG file's bytes; `quality` 0 .. 100. Errors (kind input): sizes that contradict each other,
/// 16 bits.
[[nodiscard]] Expected<std::vector<std::uint8_t>> encode_jpeg(const Image& image, int quality);

}  // namespace rigcal
