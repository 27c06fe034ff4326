#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace rigcal {

/// The middle one of some numbers, in their unit; of an even count the larger of the two; 0 of none.
template <class Number>
[[nodiscard]] Number median(std::vector<Number> values) {
  if (values.empty()) return Number{};
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace rigcal
