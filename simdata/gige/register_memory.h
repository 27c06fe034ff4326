#pragma once

#include <cstdint>
#include <vector>

#include "core/base/bytes.h"
#include "drivers/gige_codec/status.h"

namespace rigcal::sim {

/// The memory of a device: registers of four bytes in network order, and which of them there are.
class RegisterMemory {
 public:
  enum class Access : std::uint8_t { none, read, write };  ///< What can be written can be read, too.

  explicit RegisterMemory(std::size_t bytes) : bytes_((bytes + 3) / 4 * 4), access_(bytes_.size() / 4) {}

  /// `address` must be a multiple of 4 within the memory, here and below.
  void define(std::uint32_t address, std::uint32_t value, Access access);
  /// Bytes that are filled up with zeros to a multiple of 4.
  void define_bytes(std::uint32_t address, ByteView bytes, Access access);

  [[nodiscard]] std::uint32_t value(std::uint32_t address) const;
  void set(std::uint32_t address, std::uint32_t value);
  [[nodiscard]] float real(std::uint32_t address) const;
  void set_real(std::uint32_t address, double value);

  /// Whether all of these bytes may be read, or written; any address is safe. Errors: bad_alignment, invalid_address,
  /// write_protected.
  [[nodiscard]] gige::Status check(std::uint32_t address, std::size_t size, Access wanted) const;
  /// After `check`.
  [[nodiscard]] ByteView view(std::uint32_t address, std::size_t size) const {
    return ByteView(bytes_).subspan(address, size);
  }

 private:
  std::vector<std::uint8_t> bytes_;
  std::vector<Access> access_;  ///< Of each four bytes.
};

}  // namespace rigcal::sim
