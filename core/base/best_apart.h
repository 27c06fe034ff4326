#pragma once

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

namespace rigcal {

/// The best (by their `score`; equal ones in their order) that stand apart, at most `most`, the best first: of two that
/// are `near(better, worse)` only the better one is kept.
template <class T, class Near>
[[nodiscard]] std::vector<T> best_apart(std::vector<T> all, std::size_t most, const Near& near) {
  std::stable_sort(all.begin(), all.end(), [](const T& a, const T& b) { return a.score > b.score; });
  std::vector<T> out;
  for (T& each : all) {
    if (out.size() >= most) break;
    if (std::none_of(out.begin(), out.end(), [&](const T& better) { return near(better, each); }))
      out.push_back(std::move(each));
  }
  return out;
}

}  // namespace rigcal
