#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "core/base/random.h"

namespace rigcal {

/// A copy of a file that one to four accidents have happened to: flipped bits, bytes set to what programs stumble over,
/// parts missing, doubled or exchanged, an early end, digits made large.
inline std::vector<std::uint8_t> mutated(const std::vector<std::uint8_t>& original, Random& random) {
  using Bytes = std::vector<std::uint8_t>;
  Bytes bytes = original;
  const auto below = [&random](std::size_t limit) {
    return static_cast<std::size_t>(random.uniform() * static_cast<double>(limit));
  };
  const auto place = [&bytes, &below] { return bytes.begin() + static_cast<std::ptrdiff_t>(below(bytes.size())); };
  const auto part_of = [&bytes, &below](Bytes::iterator begin) {
    const auto left = static_cast<std::size_t>(bytes.end() - begin);
    return begin + static_cast<std::ptrdiff_t>(std::min(left, 1 + below(40)));
  };
  const std::size_t accidents = 1 + below(4);
  for (std::size_t i = 0; i < accidents && !bytes.empty(); ++i) {
    const auto at = place();
    const auto end = part_of(at);
    switch (below(8)) {
      case 0:
        *at = static_cast<std::uint8_t>(*at ^ (1U << below(8)));
        break;
      case 1:
        std::fill(at, end, std::uint8_t{0xFF});
        break;
      case 2:
        std::fill(at, end, std::uint8_t{0});
        break;
      case 3:
        bytes.erase(at, end);
        break;
      case 4: {
        const Bytes part(at, end);
        bytes.insert(at, part.begin(), part.end());
        break;
      }
      case 5:
        bytes.erase(at, bytes.end());
        break;
      case 6:
        std::swap_ranges(
            at, end,
            bytes.begin() + static_cast<std::ptrdiff_t>(below(bytes.size() - static_cast<std::size_t>(end - at) + 1)));
        break;
      default:
        for (auto byte = at; byte != end; ++byte) {
          if (*byte >= '0' && *byte <= '9') *byte = '9';
        }
    }
  }
  return bytes;
}

}  // namespace rigcal
