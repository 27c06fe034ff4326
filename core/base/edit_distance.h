#pragma once

#include <cstddef>
#include <string_view>

namespace rigcal {

/// How many letters must be added, taken away or changed to make one word of the other (Levenshtein).
[[nodiscard]] std::size_t edit_distance(std::string_view a, std::string_view b);

}  // namespace rigcal
