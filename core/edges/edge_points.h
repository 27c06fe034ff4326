#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/edges/edge_candidates.h"
#include "core/voxel/cube_key.h"
#include "core/voxel/key_numbers.h"

namespace rigcal {

/// A point of the map near an edge, in the world.
struct EdgePoint {
  Eigen::Vector3f p_G;
  Eigen::Vector3f ray_G;  ///< Unit vector from the sensor.
  float range_m = 0.0F;
  std::uint16_t lidar = 0;

  /// Variance of its distance to a plane with the unit normal n, m^2.
  [[nodiscard]] double variance_along(const Vector3d& n, const NoiseModel& noise) const;
};

/// The thinned points of all patches around the pieces, sorted by cubes so that those around a place are found.
class EdgePoints {
 public:
  EdgePoints(const std::vector<EdgePiece>& pieces, const std::vector<PatchCells>& patches, const RigState& state,
             const std::vector<char>& use, double reach_m);

  /// The points of the cubes that come within `radius_m` of p, appended to `found` cube by cube.
  void around(const Vector3d& p, double radius_m, std::vector<std::span<const EdgePoint>>& found) const;
  [[nodiscard]] std::size_t size() const { return points_.size(); }

 private:
  KeyNumbers cubes_;
  std::vector<std::size_t> starts_;  ///< Of each cube's points; one more than cubes.
  std::vector<EdgePoint> points_;
};

}  // namespace rigcal
