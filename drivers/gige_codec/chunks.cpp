#include "drivers/gige_codec/chunks.h"

#include <algorithm>
#include <string>

#include "core/base/network_order.h"

namespace rigcal::gige {

void close_chunk(std::vector<std::uint8_t>& out, std::uint32_t id, std::size_t size) {
  RIGCAL_ASSERT(size <= out.size() && size <= UINT32_MAX, "a chunk longer than its block");
  ByteWriter writer(out);
  write_network(writer, id);
  write_network(writer, static_cast<std::uint32_t>(size));
}

Expected<std::vector<Chunk>> split_chunks(ByteView block) {
  std::vector<Chunk> chunks;
  ByteView left = block;
  while (!left.empty()) {
    const auto wrong = [&left](const std::string& what) {
      return input_error(what, "byte " + std::to_string(left.size()) + " of a GigE Vision block with chunks");
    };
    if (left.size() < kChunkTagBytes) return wrong("a chunk without its tag");
    ByteReader tag(left.last(kChunkTagBytes));
    left = left.first(left.size() - kChunkTagBytes);
    Chunk chunk;
    chunk.id = read_network<std::uint32_t>(tag);
    const auto size = read_network<std::uint32_t>(tag);
    if (size > left.size()) return wrong("a chunk of " + std::to_string(size) + " bytes begins before the block");
    chunk.bytes = left.last(size);
    left = left.first(left.size() - size);
    chunks.push_back(chunk);
  }
  std::reverse(chunks.begin(), chunks.end());
  return chunks;
}

}  // namespace rigcal::gige
