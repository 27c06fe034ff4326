#pragma once

#include <cstdint>
#include <vector>

#include "core/voxel/cells.h"

namespace rigcal {

/// What stands around one place of a cloud, whatever it is: a wall is flat, a pole is long, a bush is round. Where a
/// LiDAR's surfels are few, these still say how everything it saw lies on what another saw.
struct LocalShape {
  Vector3d mean = Vector3d::Zero();
  Matrix3d covariance = Matrix3d::Zero();  ///< Of the surface around it, m^2.
};

/// The shapes of one patch, one for each occupied cube of `size_m`, in the sensor's frame. The neighbourhood of each
/// grows until it is no line any more: a single ring of a spinning LiDAR is a line, the ground it lies on is not. What
/// is still one when the neighbourhood is as large as its range allows is a pole, an edge or a kerb. Places with too
/// few neighbours are left out.
[[nodiscard]] std::vector<LocalShape> extract_shapes(const PatchCells& patch, double size_m);

/// The first of all shapes in each cube of `size_m`: what many stops have seen is kept once.
[[nodiscard]] std::vector<LocalShape> without_repetitions(const std::vector<LocalShape>& shapes, double size_m);

/// Finds the shape nearest to a place.
class ShapeIndex {
 public:
  /// `reach_m`: how far a shape's mean may be from a query.
  ShapeIndex(const std::vector<LocalShape>& shapes, double reach_m);

  /// Index of the shape whose mean is nearest to `p`, within the reach; or -1.
  [[nodiscard]] int nearest(const Vector3d& p) const;
  [[nodiscard]] const LocalShape& operator[](int i) const { return shapes_[static_cast<std::size_t>(i)]; }
  [[nodiscard]] double reach_m() const { return reach_m_; }

 private:
  std::vector<LocalShape> shapes_;  // one bucket after the other
  std::vector<Vector3d> means_;     // theirs once more: most of them are only looked at for where they are
  double reach_m_;
  std::size_t mask_ = 0;
  std::vector<std::uint32_t> bucket_start_;
};

}  // namespace rigcal
