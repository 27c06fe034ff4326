#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>

#include "core/base/bytes.h"

/// Integers in network order (big-endian) off and onto the little-endian readers and writers of bytes.h.
namespace rigcal {

template <std::unsigned_integral T>
[[nodiscard]] constexpr T swap_bytes(T value) {
  T swapped = 0;
  for (std::size_t i = 0; i < sizeof(T); ++i) {
    swapped = static_cast<T>((swapped << 7U) << 1U) | static_cast<T>(value & 0xFFU);
    value = static_cast<T>((value >> 7U) >> 1U);
  }
  return swapped;
}

template <std::unsigned_integral T>
[[nodiscard]] T read_network(ByteReader& reader) {
  return swap_bytes(reader.read<T>());
}

template <std::unsigned_integral T>
void write_network(ByteWriter& writer, T value) {
  writer.write(swap_bytes(value));
}

}  // namespace rigcal
