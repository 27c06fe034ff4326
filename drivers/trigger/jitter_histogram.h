#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>

namespace rigcal::trigger {

/// How far times were off. Constant memory.
class JitterHistogram {
 public:
  /// Upper ends of the bins, by the distance from zero; the last bin takes all that is beyond.
  static constexpr std::array<std::int64_t, 15> kEnds_ns{1'000,     2'000,     5'000,      10'000,     20'000,
                                                         50'000,    100'000,   200'000,    500'000,    1'000'000,
                                                         2'000'000, 5'000'000, 10'000'000, 20'000'000, 50'000'000};

  void add(std::int64_t off_ns);

  [[nodiscard]] std::uint64_t count() const { return count_; }
  [[nodiscard]] std::uint64_t bin(std::size_t index) const { return bins_[index]; }  ///< Up to kEnds_ns.size().
  [[nodiscard]] std::int64_t least_ns() const { return least_; }
  [[nodiscard]] std::int64_t most_ns() const { return most_; }
  [[nodiscard]] double mean_ns() const;
  [[nodiscard]] double deviation_ns() const;

  /// A line for each bin from the first to the last that has something, and one with the figures.
  [[nodiscard]] std::string text() const;

 private:
  std::array<std::uint64_t, kEnds_ns.size() + 1> bins_{};
  std::uint64_t count_ = 0;
  std::int64_t least_ = 0;
  std::int64_t most_ = 0;
  double mean_ = 0.0;
  double squares_ = 0.0;  ///< Sum of squared distances from the mean (Welford).
};

}  // namespace rigcal::trigger
