#include "core/corner/fitted_plane.h"

#include <algorithm>
#include <cmath>

#include "core/geometry/symmetric_eigen.h"

namespace rigcal {

std::optional<FittedPlane> fit_plane(const PointCluster& points) {
  constexpr double line = 1e-6;  // middle over largest eigenvalue: one to a thousand in width
  if (points.N < 3.0) return std::nullopt;
  const SymmetricEigen eigen = symmetric_eigen(points.covariance());
  if (!(eigen.values[1] > line * eigen.values[2])) return std::nullopt;
  FittedPlane plane;
  plane.points = points;
  plane.normal = eigen.vectors.col(0);
  plane.offset_m = plane.normal.dot(points.mean());
  plane.sigma_m = std::sqrt(std::max(0.0, eigen.values[0]));
  return plane.offset_m > 0.0 ? plane.flipped() : plane;
}

PlaneMoments moments_of(const PointCluster& points) {
  const SymmetricEigen eigen = symmetric_eigen(points.covariance());
  const Vector3d scatter = points.N * (eigen.values.array() - eigen.values[0]).matrix();
  return {points.N, points.mean(), scatter, eigen.vectors};
}

}  // namespace rigcal
