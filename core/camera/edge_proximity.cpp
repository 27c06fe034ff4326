#include "core/camera/edge_proximity.h"

#include <algorithm>
#include <cmath>

#include "core/geometry/se3.h"

namespace rigcal {
namespace {

constexpr int least_chain_px = 40;

// In units of the scale: from there on nothing is left of the nearness.
constexpr double far = 3.6;

// Distances to the nearest zero in cells, by two passes of a 3-4 chamfer (Borgefors 1986). The grid has a border of one
// cell all around, which is far from everything.
void spread(int columns, int rows, std::vector<float>& distance) {
  constexpr float straight = 0.955F;
  constexpr float diagonal = 1.3693F;
  const std::ptrdiff_t width = columns + 2;
  float* inside = distance.data() + width + 1;
  for (int y = 0; y < rows; ++y) {
    float* d = inside + y * width;
    for (int x = 0; x < columns; ++x, ++d) {
      const float above = std::min(d[-width] + straight, std::min(d[-width - 1], d[-width + 1]) + diagonal);
      *d = std::min(*d, std::min(above, d[-1] + straight));
    }
  }
  for (int y = rows - 1; y >= 0; --y) {
    float* d = inside + y * width + columns - 1;
    for (int x = columns - 1; x >= 0; --x, --d) {
      const float below = std::min(d[width] + straight, std::min(d[width - 1], d[width + 1]) + diagonal);
      *d = std::min(*d, std::min(below, d[1] + straight));
    }
  }
}

}  // namespace

EdgeProximity::EdgeProximity(int width, int height, const EdgeIndex& index, double scale_px)
    : columns_((width + cell_px - 1) / cell_px), rows_((height + cell_px - 1) / cell_px) {
  for (int k = 0; k < directions; ++k) {
    const double angle = pi * (k + 0.5) / directions;
    borders_x_[static_cast<std::size_t>(k)] = static_cast<float>(std::cos(angle));
    borders_y_[static_cast<std::size_t>(k)] = static_cast<float>(std::sin(angle));
  }
  const auto columns = static_cast<std::size_t>(columns_);
  const auto rows = static_cast<std::size_t>(rows_);
  std::array<std::vector<float>, directions> distance;
  distance.fill(std::vector<float>((columns + 2) * (rows + 2), 1e6F));
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
    const std::size_t s = sector({-edge.normal.y(), edge.normal.x()});
    // What lies at the border of a sector belongs to its neighbour as well.
    for (const std::size_t k : {s + directions - 1, s, s + 1}) {
      distance[k % directions][(static_cast<std::size_t>(y) + 1) * (columns + 2) + static_cast<std::size_t>(x) + 1] =
          0.0F;
    }
  }
  for (std::size_t s = 0; s < distance.size(); ++s) {
    spread(columns_, rows_, distance[s]);
    nearness_[s].resize(columns * rows);
    for (std::size_t y = 0; y < rows; ++y) {
      const float* from = distance[s].data() + (y + 1) * (columns + 2) + 1;
      for (std::size_t x = 0; x < columns; ++x) {
        const double d = static_cast<double>(from[x]) * cell_px / scale_px;
        if (d > far) continue;
        nearness_[s][y * columns + x] = static_cast<std::uint8_t>(std::lround(255.0 * std::exp(-0.5 * d * d)));
      }
    }
  }
}

// The first is around the x axis; what is turned by half a turn lies in the same.
std::size_t EdgeProximity::sector(const Eigen::Vector2f& along) const {
  const float sign = along.y() < 0.0F ? -1.0F : 1.0F;
  const float x = sign * along.x();
  const float y = sign * along.y();
  std::uint32_t passed = 0;
  for (std::size_t k = 0; k < directions; ++k) passed += borders_x_[k] * y - borders_y_[k] * x >= 0.0F ? 1U : 0U;
  return passed % directions;
}

float EdgeProximity::at(const Eigen::Vector2f& pixel, const Eigen::Vector2f& along) const {
  const float x = (pixel.x() + 0.5F) / cell_px;
  const float y = (pixel.y() + 0.5F) / cell_px;
  if (!(x >= 0.0F && y >= 0.0F && x < static_cast<float>(columns_) && y < static_cast<float>(rows_))) return 0.0F;
  const auto place = static_cast<std::size_t>(static_cast<int>(y) * columns_ + static_cast<int>(x));
  return static_cast<float>(nearness_[sector(along)][place]) / 255.0F;
}

}  // namespace rigcal
