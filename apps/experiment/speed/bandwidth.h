#pragma once

#include <cstddef>

namespace rigcal::speed {

/// What the machine's memory gives to all threads of `parallel_for` together.
struct Bandwidth {
  double read_bytes_per_s = 0.0;
  double copy_bytes_per_s = 0.0;  ///< Bytes read and bytes written, added up.
};

/// Sums and copies a buffer of so many bytes, which should be much larger than the caches; the best of five times.
[[nodiscard]] Bandwidth measure_bandwidth(std::size_t bytes);

}  // namespace rigcal::speed
