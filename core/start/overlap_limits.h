#pragma once

#include <cstddef>

namespace rigcal {

// What the searches of a start take for no overlap. Scores are shares of surfels, from 0 to 1.

/// Fewer surfels than this are no view.
inline constexpr std::size_t min_surfels = 20;
/// Of what a LiDAR saw, a smaller share than this that lies on what others saw is no match.
inline constexpr double min_score = 0.15;
/// The same of what it saw itself from other stops.
inline constexpr double min_own_score = 0.1;

}  // namespace rigcal
