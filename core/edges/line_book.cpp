#include "core/edges/line_book.h"

#include <algorithm>
#include <cmath>

namespace rigcal {

void LineBook::add(const std::vector<LidarEdge>& piece) {
  if (piece.empty()) return;
  const LidarEdge& middle = piece[piece.size() / 2];
  std::size_t line = 0;
  while (line < lines_.size() && !is_on(lines_[line], middle)) ++line;
  if (line == lines_.size()) lines_.push_back({middle.p_G, middle.direction_G, {}});
  Line& book = lines_[line];
  for (const LidarEdge& edge : piece) {
    const auto at = static_cast<std::int64_t>(std::floor(book.direction.dot(edge.p_G - book.p) / sample_m_));
    const auto place = std::lower_bound(book.taken.begin(), book.taken.end(), at);
    if (place != book.taken.end() && *place == at) continue;
    book.taken.insert(place, at);
    edges_.push_back(edge);
    edges_.back().line = first_line_ + static_cast<int>(line);
  }
}

bool LineBook::is_on(const Line& line, const LidarEdge& edge) {
  if (std::abs(line.direction.dot(edge.direction_G)) < std::cos(to_rad(4.0))) return false;
  const Vector3d d = edge.p_G - line.p;
  const double along = line.direction.dot(d);
  return (d - along * line.direction).norm() < 0.02 + 0.01 * std::abs(along);
}

}  // namespace rigcal
