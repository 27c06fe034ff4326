#pragma once

#include <cstdint>

namespace rigcal {

/// The greatest integer that is not above `value`, for what fits it. As std::floor, which calls a function where the
/// program is built for processors without SSE 4.1.
[[nodiscard]] inline std::int64_t floor_of(double value) {
  const auto whole = static_cast<std::int64_t>(value);
  return whole - static_cast<std::int64_t>(static_cast<double>(whole) > value);
}

}  // namespace rigcal
