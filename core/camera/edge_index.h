#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/edges/image_edges.h"

namespace rigcal {

/// The edges of one image, sorted by squares of a few pixels, so that those near a place are found.
class EdgeIndex {
 public:
  EdgeIndex() = default;
  EdgeIndex(int width, int height, const std::vector<ImageEdge>& edges);

  [[nodiscard]] std::size_t size() const { return edges_.size(); }
  [[nodiscard]] const std::vector<ImageEdge>& edges() const { return edges_; }

  /// Calls `visit(edge)` for every edge in the squares that touch the box of `reach` pixels around `centre`.
  template <class Visit>
  void around(const Eigen::Vector2d& centre, const Eigen::Vector2d& reach, const Visit& visit) const {
    const int x0 = std::max(0, square(centre.x() - reach.x()));
    const int x1 = std::min(columns_ - 1, square(centre.x() + reach.x()));
    const int y0 = std::max(0, square(centre.y() - reach.y()));
    const int y1 = std::min(rows_ - 1, square(centre.y() + reach.y()));
    if (x0 > x1) return;
    for (int y = y0; y <= y1; ++y) {
      const std::size_t row = static_cast<std::size_t>(y) * static_cast<std::size_t>(columns_);
      const std::uint32_t end = starts_[row + static_cast<std::size_t>(x1) + 1];
      for (std::uint32_t i = starts_[row + static_cast<std::size_t>(x0)]; i < end; ++i) visit(edges_[i]);
    }
  }

 private:
  static constexpr int square_px = 8;
  [[nodiscard]] static int square(double pixel) { return static_cast<int>(std::floor((pixel + 0.5) / square_px)); }

  int columns_ = 0;
  int rows_ = 0;
  std::vector<ImageEdge> edges_;       ///< By squares, row by row.
  std::vector<std::uint32_t> starts_;  ///< Of each square's edges; one more than squares.
};

}  // namespace rigcal
