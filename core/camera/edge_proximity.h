#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/camera/edge_index.h"

namespace rigcal {

/// How near any place of an image is to an edge of a given direction: quick to ask, and smooth enough to be searched
/// (directional chamfer matching). Only long chains count; short ones are texture.
class EdgeProximity {
 public:
  /// Nearness falls to exp(-1/2) at `scale_px`.
  EdgeProximity(int width, int height, const EdgeIndex& index, double scale_px);

  /// 0 .. 1; 0 outside of the image. `along` is the direction of the edge, of any length and sign.
  [[nodiscard]] float at(const Eigen::Vector2f& pixel, const Eigen::Vector2f& along) const;

 private:
  static constexpr int cell_px = 4;
  static constexpr int directions = 8;  ///< Over half a turn.

  [[nodiscard]] std::size_t sector(const Eigen::Vector2f& along) const;

  int columns_ = 0;
  int rows_ = 0;
  std::array<float, directions> borders_x_;  ///< Between the sectors, unit, going up.
  std::array<float, directions> borders_y_;
  std::array<std::vector<std::uint8_t>, directions> nearness_;
};

}  // namespace rigcal
