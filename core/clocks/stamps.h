#pragma once

#include <cstdint>

namespace rigcal {

/// Stamps come from the wire and may be anything: their differences and sums wrap around instead of overflowing.
[[nodiscard]] constexpr std::int64_t stamp_difference(std::int64_t a, std::int64_t b) {
  return static_cast<std::int64_t>(static_cast<std::uint64_t>(a) - static_cast<std::uint64_t>(b));
}
[[nodiscard]] constexpr std::int64_t stamp_sum(std::int64_t a, std::int64_t b) {
  return static_cast<std::int64_t>(static_cast<std::uint64_t>(a) + static_cast<std::uint64_t>(b));
}

}  // namespace rigcal
