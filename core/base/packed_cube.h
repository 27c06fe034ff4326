#pragma once

#include <cstdint>

namespace rigcal {

/// A cube of a grid by its indices as one number: those within 2^20 of the origin along each axis have different ones,
/// in the order of x, then y, then z.
[[nodiscard]] inline std::uint64_t packed_cube(std::int64_t x, std::int64_t y, std::int64_t z) {
  const auto part = [](std::int64_t v) { return static_cast<std::uint64_t>(v + (1 << 20)) & 0x1FFFFF; };
  return part(x) << 42 | part(y) << 21 | part(z);
}

/// One index of such a cube: `axis` 0 to 2.
[[nodiscard]] inline std::int64_t index_of_packed(std::uint64_t cube, int axis) {
  return static_cast<std::int64_t>(cube >> (42 - 21 * axis) & 0x1FFFFF) - (1 << 20);
}

}  // namespace rigcal
