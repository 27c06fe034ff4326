#pragma once

#include <cstdint>
#include <vector>

#include "core/base/bytes.h"
#include "core/base/error.h"

namespace rigcal::gige {

/// A part of a block with chunks: bytes, then what they are and how many. `bytes` points into the block.
struct Chunk {
  std::uint32_t id = 0;
  ByteView bytes;
};

constexpr std::size_t kChunkTagBytes = 8;

/// Closes what `out` has had since its last chunk ended, `size` bytes, as a chunk.
void close_chunk(std::vector<std::uint8_t>& out, std::uint32_t id, std::size_t size);

/// The chunks of a block in their order; they are found from its end. Errors: a chunk that begins before the block.
[[nodiscard]] Expected<std::vector<Chunk>> split_chunks(ByteView block);

}  // namespace rigcal::gige
