#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace rigcal {

/// The number that `rank` others are not above, in their unit; puts them into another order. `rank` must be below their
/// count.
template <class Number>
[[nodiscard]] Number of_rank(std::vector<Number>& values, std::size_t rank) {
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(rank);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

/// The number below which such a share of the others lies, 0 to 1: 0.01 is the first percentile. Of one number at
/// least, which are put into another order.
template <class Number>
[[nodiscard]] Number quantile(std::vector<Number>& values, double share) {
  return of_rank(values, static_cast<std::size_t>(share * static_cast<double>(values.size() - 1)));
}

/// The middle one of some numbers, in their unit; of an even count the larger of the two; 0 of none.
template <class Number>
[[nodiscard]] Number median(std::vector<Number> values) {
  return values.empty() ? Number{} : of_rank(values, values.size() / 2);
}

/// Sigma of a normal variable about zero, over the median of its absolute values.
inline constexpr double sigma_per_median_size = 1.4826;

}  // namespace rigcal
