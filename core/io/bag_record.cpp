#include "core/io/bag_record.h"

#include <bzlib.h>
#include <lz4frame.h>

#include <algorithm>
#include <memory>

#include "core/base/seconds.h"

namespace rigcal {
namespace {

constexpr std::size_t first_room = std::size_t{1} << 20;

Error damaged() { return input_error("its compressed part is damaged"); }

/// Doubles `out` up to `size`; false where it has that size already.
bool grow(std::vector<std::uint8_t>& out, std::size_t size) {
  if (out.size() >= size) return false;
  out.resize(std::min(size, std::max(first_room, 2 * out.size())));
  return true;
}

Expected<void> unpack_bz2(ByteView packed, std::size_t size, std::vector<std::uint8_t>& out) {
  bz_stream stream = {};
  if (BZ2_bzDecompressInit(&stream, 0, 0) != BZ_OK) return system_error("no memory for bz2");
  const auto end = [](bz_stream* s) { BZ2_bzDecompressEnd(s); };
  const std::unique_ptr<bz_stream, decltype(end)> guard(&stream, end);
  // The library never writes to its input.
  stream.next_in = const_cast<char*>(reinterpret_cast<const char*>(packed.data()));
  stream.avail_in = static_cast<unsigned>(packed.size());
  std::size_t done = 0;
  while (true) {
    if (done == out.size() && !grow(out, size)) {
      // All is out; what is left of the input can only be the checksum.
      char nothing = 0;
      stream.next_out = &nothing;
      stream.avail_out = 1;
      const int code = BZ2_bzDecompress(&stream);
      return code == BZ_STREAM_END && stream.avail_out == 1 ? Expected<void>{} : damaged();
    }
    stream.next_out = reinterpret_cast<char*>(out.data()) + done;
    stream.avail_out = static_cast<unsigned>(out.size() - done);
    const int code = BZ2_bzDecompress(&stream);
    const std::size_t now = out.size() - stream.avail_out;
    const bool stuck = now == done && stream.avail_in == 0;
    done = now;
    if (code == BZ_STREAM_END) return done == size ? Expected<void>{} : damaged();
    if (code != BZ_OK || stuck) return damaged();
  }
}

Expected<void> unpack_lz4(ByteView packed, std::size_t size, std::vector<std::uint8_t>& out) {
  LZ4F_dctx* context = nullptr;
  if (LZ4F_isError(LZ4F_createDecompressionContext(&context, LZ4F_VERSION)) != 0) {
    return system_error("no memory for lz4");
  }
  const std::unique_ptr<LZ4F_dctx, decltype(&LZ4F_freeDecompressionContext)> guard(context,
                                                                                   &LZ4F_freeDecompressionContext);
  std::size_t done = 0;
  while (true) {
    static_cast<void>(done == out.size() && grow(out, size));
    std::size_t out_bytes = out.size() - done;
    std::size_t in_bytes = packed.size();
    const std::size_t code = LZ4F_decompress(context, out.data() + done, &out_bytes, packed.data(), &in_bytes, nullptr);
    if (LZ4F_isError(code) != 0) return damaged();
    done += out_bytes;
    packed = packed.subspan(in_bytes);
    if (code == 0) return done == size ? Expected<void>{} : damaged();
    if (out_bytes == 0 && in_bytes == 0) return damaged();
  }
}

}  // namespace

std::optional<ByteView> BagFields::find(std::string_view name) const {
  ByteReader reader(bytes_);
  while (reader.left() > 0) {
    const auto length = reader.read<std::uint32_t>();
    const ByteView field = reader.take(length);
    if (!reader.ok()) return std::nullopt;
    const auto equals = std::find(field.begin(), field.end(), '=');
    if (equals == field.end()) return std::nullopt;
    if (std::equal(field.begin(), equals, name.begin(), name.end())) {
      return field.subspan(static_cast<std::size_t>(equals - field.begin()) + 1);
    }
  }
  return std::nullopt;
}

std::optional<std::string> BagFields::text(std::string_view name) const {
  const std::optional<ByteView> value = find(name);
  if (!value) return std::nullopt;
  return std::string(value->begin(), value->end());
}

std::optional<std::int64_t> BagFields::time_ns(std::string_view name) const {
  const std::optional<ByteView> value = find(name);
  if (!value || value->size() != 8) return std::nullopt;
  ByteReader reader(*value);
  const std::int64_t seconds = reader.read<std::uint32_t>();
  return seconds * ns_per_second + reader.read<std::uint32_t>();
}

std::optional<BagOp> BagFields::op() const {
  const std::optional<std::uint8_t> value = number<std::uint8_t>("op");
  if (!value) return std::nullopt;
  return static_cast<BagOp>(*value);
}

std::optional<BagRecord> take_bag_record(ByteReader& reader) {
  if (reader.left() == 0) return std::nullopt;
  const auto header_bytes = reader.read<std::uint32_t>();
  const ByteView header = reader.take(header_bytes);
  const auto data_bytes = reader.read<std::uint32_t>();
  const ByteView data = reader.take(data_bytes);
  if (!reader.ok()) return std::nullopt;
  return BagRecord{BagFields(header), data};
}

std::string printable(std::string_view text) {
  std::string out(text);
  for (char& c : out) {
    if (c < ' ' || c > '~') c = '?';
  }
  return out;
}

Expected<void> unpack_chunk(std::string_view compression, ByteView packed, std::uint64_t size,
                            std::vector<std::uint8_t>& out) {
  out.clear();
  if (size > max_chunk_bytes || packed.size() > max_chunk_bytes) {
    return input_error("it holds more than " + std::to_string(max_chunk_bytes >> 20U) + " MB");
  }
  if (compression == "bz2") return unpack_bz2(packed, size, out);
  if (compression == "lz4") return unpack_lz4(packed, size, out);
  return input_error("its compression '" + printable(compression.substr(0, 20)) + "' is not known");
}

}  // namespace rigcal
