#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "core/base/bytes.h"
#include "core/base/error.h"

namespace rigcal {

/// What a record of a bag (format 2.0) is, by its field "op".
enum class BagOp : std::uint8_t {
  message = 2,
  bag_header = 3,
  index = 4,
  chunk = 5,
  chunk_info = 6,
  connection = 7,
};

/// The name=value fields of a record's header. The view must outlive it.
class BagFields {
 public:
  explicit BagFields(ByteView bytes) : bytes_(bytes) {}

  /// The value of a field; nothing where it is not there, or stands behind damage.
  [[nodiscard]] std::optional<ByteView> find(std::string_view name) const;
  [[nodiscard]] std::optional<std::string> text(std::string_view name) const;
  /// A little-endian number; nothing where the field has not its size.
  template <class T>
  [[nodiscard]] std::optional<T> number(std::string_view name) const {
    const std::optional<ByteView> value = find(name);
    if (!value || value->size() != sizeof(T)) return std::nullopt;
    return ByteReader(*value).read<T>();
  }
  /// A ROS time (seconds and nanoseconds, 32 bits each) in ns.
  [[nodiscard]] std::optional<std::int64_t> time_ns(std::string_view name) const;
  [[nodiscard]] std::optional<BagOp> op() const;

 private:
  ByteView bytes_;
};

/// A record inside a chunk.
struct BagRecord {
  BagFields fields;
  ByteView data;
};

/// Takes the next record off `reader`; nothing at the end and where it does not fit (then `reader.ok()` is false).
[[nodiscard]] std::optional<BagRecord> take_bag_record(ByteReader& reader);

/// Printable text of a name from outside: anything but printable ASCII becomes '?'.
[[nodiscard]] std::string printable(std::string_view text);

/// The largest chunk that is read. Recorders write chunks of 768 KB, or one message where that is larger.
constexpr std::uint64_t max_chunk_bytes = std::uint64_t{256} << 20;

/// Replaces `out` by what a compressed chunk ("bz2" or "lz4") holds: exactly `size` bytes, at most `max_chunk_bytes`.
/// Memory is taken as bytes come out, not as `size` promises. The Error says what is wrong, without a place.
[[nodiscard]] Expected<void> unpack_chunk(std::string_view compression, ByteView packed, std::uint64_t size,
                                          std::vector<std::uint8_t>& out);

}  // namespace rigcal
