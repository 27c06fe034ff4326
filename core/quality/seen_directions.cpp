#include "core/quality/seen_directions.h"

#include <algorithm>
#include <cmath>

namespace rigcal {

std::array<int, 2> SeenDirections::place(const Vector3d& p) {
  const double elevation = std::atan2(p.z(), std::hypot(p.x(), p.y()));
  const double azimuth = std::atan2(p.y(), p.x());
  return {std::clamp(static_cast<int>((elevation / pi + 0.5) * rows), 0, rows - 1),
          std::clamp(static_cast<int>((azimuth / (2.0 * pi) + 0.5) * columns), 0, columns - 1)};
}

void SeenDirections::add(const Vector3d& p) {
  const auto [row, column] = place(p);
  for (int r = std::max(0, row - 1); r <= std::min(rows - 1, row + 1); ++r) {
    for (int c = column - 1; c <= column + 1; ++c) {
      is_seen_[static_cast<std::size_t>(r * columns + (c + columns) % columns)] = true;
    }
  }
}

bool SeenDirections::contains(const Vector3d& p) const {
  const auto [row, column] = place(p);
  return is_seen_[static_cast<std::size_t>(row * columns + column)];
}

}  // namespace rigcal
