#include "core/camera/edge_proximity.h"

#include <algorithm>
#include <cmath>

#include "core/geometry/se3.h"

namespace rigcal {
namespace {

constexpr int least_chain_px = 40;

// Which of `count` sectors of half a turn a line's direction lies in.
int sector(double x, double y, int count) {
  const double turn = std::atan2(y, x) / pi * count + 0.5;
  return (static_cast<int>(std::floor(turn)) % count + count) % count;
}

// Distances to the nearest zero in cells, by two passes of a 3-4 chamfer (Borgefors 1986).
void spread(int columns, int rows, std::vector<float>& distance) {
  const auto at = [&](int x, int y) -> float& {
    return distance[static_cast<std::size_t>(y) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(x)];
  };
  constexpr float straight = 0.955F;
  constexpr float diagonal = 1.3693F;
  const auto pass = [&](int y, int x, int dy, int dx) {
    float& d = at(x, y);
    const auto relax = [&](int ox, int oy, float step) {
      if (x + ox < 0 || x + ox >= columns || y + oy < 0 || y + oy >= rows) return;
      d = std::min(d, at(x + ox, y + oy) + step);
    };
    relax(dx, 0, straight);
    relax(0, dy, straight);
    relax(-1, dy, diagonal);
    relax(1, dy, diagonal);
  };
  for (int y = 0; y < rows; ++y) {
    for (int x = 0; x < columns; ++x) pass(y, x, -1, -1);
  }
  for (int y = rows - 1; y >= 0; --y) {
    for (int x = columns - 1; x >= 0; --x) pass(y, x, 1, 1);
  }
}

}  // namespace

EdgeProximity::EdgeProximity(int width, int height, const EdgeIndex& index, double scale_px)
    : columns_((width + cell_px - 1) / cell_px), rows_((height + cell_px - 1) / cell_px) {
  const std::size_t cells = static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_);
  std::array<std::vector<float>, directions> distance;
  distance.fill(std::vector<float>(cells, 1e6F));
  std::vector<int> length;
  for (const ImageEdge& edge : index.edges()) {
    const auto chain = static_cast<std::size_t>(edge.chain);
    if (chain >= length.size()) length.resize(chain + 1, 0);
    ++length[chain];
  }
  for (const ImageEdge& edge : index.edges()) {
    if (length[static_cast<std::size_t>(edge.chain)] < least_chain_px) continue;
    const int x = std::clamp(static_cast<int>((edge.position.x() + 0.5F) / cell_px), 0, columns_ - 1);
    const int y = std::clamp(static_cast<int>((edge.position.y() + 0.5F) / cell_px), 0, rows_ - 1);
    const int s = sector(-static_cast<double>(edge.normal.y()), static_cast<double>(edge.normal.x()), directions);
    // What lies at the border of a sector belongs to its neighbour as well.
    for (const int k : {s + directions - 1, s, s + 1}) {
      distance[static_cast<std::size_t>(k % directions)]
              [static_cast<std::size_t>(y) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(x)] = 0.0F;
    }
  }
  for (std::size_t s = 0; s < distance.size(); ++s) {
    spread(columns_, rows_, distance[s]);
    nearness_[s].resize(cells);
    for (std::size_t i = 0; i < cells; ++i) {
      const double d = static_cast<double>(distance[s][i]) * cell_px / scale_px;
      nearness_[s][i] = static_cast<std::uint8_t>(std::lround(255.0 * std::exp(-0.5 * d * d)));
    }
  }
}

float EdgeProximity::at(const Eigen::Vector2d& pixel, const Eigen::Vector2d& along) const {
  const int x = static_cast<int>(std::floor((pixel.x() + 0.5) / cell_px));
  const int y = static_cast<int>(std::floor((pixel.y() + 0.5) / cell_px));
  if (x < 0 || y < 0 || x >= columns_ || y >= rows_) return 0.0F;
  const auto& map = nearness_[static_cast<std::size_t>(sector(along.x(), along.y(), directions))];
  return static_cast<float>(
             map[static_cast<std::size_t>(y) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(x)]) /
         255.0F;
}

}  // namespace rigcal
