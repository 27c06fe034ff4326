#pragma once

#include "core/planes/normal_equations.h"

namespace rigcal {

/// A place in the frame of a LiDAR at a stop.
struct SensorPoint {
  int stop = 0;
  int lidar = 0;
  Vector3d p = Vector3d::Zero();
};

/// How far `a` lies above the plane through `b` with the unit normal `normal_G`, m, world frame.
[[nodiscard]] double plane_distance(const SensorPoint& a, const SensorPoint& b, const Vector3d& normal_G,
                                    const RigState& state);

/// Adds weight * distance^2 to `sum`, the normal held: cost, gradient and the Gauss-Newton Hessian's lower triangle,
/// for right perturbations [rad; m] of the free blocks. With J the derivative of the distance d = n.(G_a E_a a - G_b
/// E_b b): g += 2 w d J^T, H += 2 w J^T J. A stop or LiDAR that both points share moves both ends.
void add_point_to_plane(const SensorPoint& a, const SensorPoint& b, const Vector3d& normal_G, double distance,
                        double weight, const ParameterLayout& layout, const RigState& state, NormalEquations& sum);

}  // namespace rigcal
