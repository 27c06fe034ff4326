#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string_view>
#include <vector>

namespace rigcal {

using ByteView = std::span<const std::uint8_t>;

static_assert(std::endian::native == std::endian::little,
              "the wire formats are read by plain copies on little-endian machines");

/// Reads little-endian values off a byte view. A read past the end gives zeros and turns `ok()` false for good, so a
/// parser may read a whole header and ask once.
class ByteReader {
 public:
  explicit ByteReader(ByteView bytes) : bytes_(bytes) {}

  template <class T>
  [[nodiscard]] T read() {
    static_assert(std::is_arithmetic_v<T>);
    T value{};
    if (bytes_.size() - offset_ < sizeof(T)) {
      ok_ = false;
      offset_ = bytes_.size();
      return value;
    }
    std::memcpy(&value, bytes_.data() + offset_, sizeof(T));
    offset_ += sizeof(T);
    return value;
  }

  /// The next `size` bytes, or an empty view (and `ok()` false) where fewer are left.
  [[nodiscard]] ByteView take(std::size_t size) {
    if (bytes_.size() - offset_ < size) {
      ok_ = false;
      offset_ = bytes_.size();
      return {};
    }
    const ByteView part = bytes_.subspan(offset_, size);
    offset_ += size;
    return part;
  }

  [[nodiscard]] bool ok() const { return ok_; }
  [[nodiscard]] std::size_t offset() const { return offset_; }
  [[nodiscard]] std::size_t left() const { return bytes_.size() - offset_; }

 private:
  ByteView bytes_;
  std::size_t offset_ = 0;
  bool ok_ = true;
};

/// Appends little-endian values to a vector.
class ByteWriter {
 public:
  explicit ByteWriter(std::vector<std::uint8_t>& out) : out_(out) {}

  template <class T>
  void write(T value) {
    static_assert(std::is_arithmetic_v<T>);
    const std::size_t at = out_.size();
    out_.resize(at + sizeof(T));
    std::memcpy(out_.data() + at, &value, sizeof(T));
  }
  void write_bytes(ByteView bytes) { out_.insert(out_.end(), bytes.begin(), bytes.end()); }
  /// `text` cut or padded with NULs to `size` bytes.
  void write_text(std::string_view text, std::size_t size) {
    for (std::size_t i = 0; i < size; ++i) out_.push_back(i < text.size() ? static_cast<std::uint8_t>(text[i]) : 0);
  }

 private:
  std::vector<std::uint8_t>& out_;
};

}  // namespace rigcal
