#pragma once

#include <cstdint>

namespace rigcal {

/// Seeded random numbers (xoshiro256++), the same on every machine and standard library. Not for secrets.
class Random {
 public:
  /// `stream` gives independent sequences of one seed, for example one a sensor or stop.
  explicit Random(std::uint64_t seed, std::uint64_t stream = 0);

  [[nodiscard]] std::uint64_t next_u64();
  [[nodiscard]] double uniform();  ///< In [0, 1).
  [[nodiscard]] double uniform(double low, double high);
  [[nodiscard]] double normal();                           ///< Mean 0, standard deviation 1.
  [[nodiscard]] std::uint64_t below(std::uint64_t bound);  ///< In 0 .. bound - 1; bound > 0.

 private:
  std::uint64_t state_[4];
  double spare_ = 0.0;
  bool has_spare_ = false;
};

}  // namespace rigcal
