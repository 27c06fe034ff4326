#pragma once

#include <cstdint>
#include <utility>
#include <vector>

namespace rigcal {

/// Sorts keys with the numbers of their owners, on several threads; no two of them may be equal, so that there is one
/// order only.
void parallel_sort(std::vector<std::pair<std::uint64_t, std::uint32_t>>& numbered_keys);

}  // namespace rigcal
