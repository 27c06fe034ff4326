#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "core/base/parallel.h"

namespace rigcal {

/// Sorts items by their member `key` (std::uint64_t) on several threads; equal ones stay in their order. Digits that
/// all keys share cost nothing: keys should differ in few, neighbouring bits.
template <class Item>
void radix_sort(std::vector<Item>& items) {
  constexpr unsigned digit_bits = 11;
  constexpr std::size_t digits = std::size_t{1} << digit_bits;
  constexpr std::size_t grain = 1 << 16;
  using Starts = std::array<std::uint32_t, digits>;
  std::uint64_t differ = 0;
  for (const Item& item : items) differ |= item.key ^ items.front().key;
  const std::size_t chunks = (items.size() + grain - 1) / grain;
  std::vector<Starts> starts(chunks);
  std::vector<Item> sorted(items.size());
  for (unsigned shift = 0; shift < 64 && differ >> shift != 0; shift += digit_bits) {
    const auto digit = [shift](const Item& item) { return static_cast<std::size_t>(item.key >> shift) & (digits - 1); };
    if ((differ >> shift & (digits - 1)) == 0) continue;
    parallel_for(items.size(), grain, [&](std::size_t begin, std::size_t end) {
      Starts& counts = starts[begin / grain];
      counts.fill(0);
      for (std::size_t i = begin; i < end; ++i) ++counts[digit(items[i])];
    });
    std::uint32_t next = 0;
    for (std::size_t d = 0; d < digits; ++d) {
      for (Starts& chunk : starts) {
        const std::uint32_t count = chunk[d];
        chunk[d] = next;
        next += count;
      }
    }
    parallel_for(items.size(), grain, [&](std::size_t begin, std::size_t end) {
      Starts& at = starts[begin / grain];
      for (std::size_t i = begin; i < end; ++i) sorted[at[digit(items[i])]++] = items[i];
    });
    items.swap(sorted);
  }
}

}  // namespace rigcal
