#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "core/base/bytes.h"

namespace rigcal {

/// The digest SHA-256 (FIPS 180-4) of bytes that come in parts.
class Sha256 {
 public:
  void add(ByteView bytes);
  /// The digest of all that was added, 64 lower case hexadecimal digits. Nothing may be added afterwards.
  [[nodiscard]] std::string finish();

 private:
  void take_block(const std::uint8_t* block);

  std::array<std::uint32_t, 8> state_{0x6a09e667, 0xbb67ae85, 0x3c6ef372, 0xa54ff53a,
                                      0x510e527f, 0x9b05688c, 0x1f83d9ab, 0x5be0cd19};
  std::array<std::uint8_t, 64> open_{};  ///< The block that is not full yet.
  std::uint64_t size_ = 0;
};

}  // namespace rigcal
