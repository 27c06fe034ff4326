#pragma once

#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>

/// Numbers of any kind out of a cloud's bytes, and into a Point. Shared by the readers of clouds.
namespace rigcal {

template <class T>
double load_value(const std::uint8_t* at) {
  T value;
  std::memcpy(&value, at, sizeof(T));
  return static_cast<double>(value);
}

/// `type`: F, U or I; `size`: 4 or 8 for F, otherwise 1, 2, 4 or 8 bytes, little-endian.
inline double load_value(const std::uint8_t* at, char type, std::size_t size) {
  if (type == 'F') return size == 4 ? load_value<float>(at) : load_value<double>(at);
  if (type == 'U') {
    if (size == 1) return load_value<std::uint8_t>(at);
    if (size == 2) return load_value<std::uint16_t>(at);
    return size == 4 ? load_value<std::uint32_t>(at) : load_value<std::uint64_t>(at);
  }
  if (size == 1) return load_value<std::int8_t>(at);
  if (size == 2) return load_value<std::int16_t>(at);
  return size == 4 ? load_value<std::int32_t>(at) : load_value<std::int64_t>(at);
}

/// A number rounded and kept within what `Whole` holds; NaN gives 0.
template <class Whole>
Whole rounded(double value) {
  constexpr Whole most = std::numeric_limits<Whole>::max();
  if (!(value > 0.0)) return 0;
  const double raised = value + 0.5;  // then cut off: values are positive, and no call as std::lround would be
  return value < static_cast<double>(most) ? static_cast<Whole>(raised) : most;
}

/// A double may be too large for a float; then the point is as good as infinite.
inline float to_float(double value) {
  constexpr double largest = 3.4e38;
  return std::abs(value) > largest ? std::numeric_limits<float>::infinity() : static_cast<float>(value);
}

}  // namespace rigcal
