#pragma once

#include <optional>
#include <span>

#include "core/geometry/point_cluster.h"

namespace rigcal {

/// A plane n.p = offset in the frame of its points, and the points (or their weighted sums) it was fitted to.
struct FittedPlane {
  Vector3d normal = Vector3d::UnitZ();  ///< Unit.
  double offset_m = 0.0;
  PointCluster points;
  double sigma_m = 0.0;  ///< Standard deviation of the points along the normal.

  [[nodiscard]] double distance(const Vector3d& p) const { return normal.dot(p) - offset_m; }
  [[nodiscard]] FittedPlane flipped() const { return {-normal, -offset_m, points, sigma_m}; }
};

/// The least-squares plane through the points of a cluster, its normal towards the origin: towards the sensor, where
/// the points stand in its frame. Nothing for fewer than three points or a line.
[[nodiscard]] std::optional<FittedPlane> fit_plane(const PointCluster& points);

/// Mean and scatter sum (p - mean)(p - mean)^T of a plane's points with the noise's own share taken out: what a plane
/// cost needs of them, up to a constant.
struct PlaneMoments {
  double N = 0.0;
  Vector3d mean = Vector3d::Zero();
  Vector3d scatter = Vector3d::Zero();   ///< Eigenvalues, ascending; the first is 0.
  Matrix3d axes = Matrix3d::Identity();  ///< Their directions as columns.
  [[nodiscard]] Matrix3d scatter_matrix() const { return axes * scatter.asDiagonal() * axes.transpose(); }
};
/// Of at least one point (m).
[[nodiscard]] PlaneMoments moments_of(const PointCluster& points);

}  // namespace rigcal
