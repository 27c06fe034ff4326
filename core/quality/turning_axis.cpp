#include "core/quality/turning_axis.h"

#include <algorithm>

#include "core/geometry/symmetric_eigen.h"
#include "core/geometry/symmetric_solve.h"

namespace rigcal {
namespace {

constexpr double least_turn_rad = to_rad(3.0);

}  // namespace

SE3 TurningAxis::turn(double angle_rad) const {
  const Matrix3d R = exp_so3(angle_rad * direction);
  return {R, point - R * point};
}

std::optional<TurningAxis> find_turning_axis(const std::vector<SE3>& T_G_base, const std::vector<char>& known,
                                             const Vector3d& about) {
  // A pose about the line is (R, (I - R) f): f from all of them; along the line nothing tells it.
  Matrix3d A = Matrix3d::Zero();
  Vector3d b = Vector3d::Zero();
  Matrix3d directions = Matrix3d::Zero();
  for (std::size_t j = 0; j < T_G_base.size(); ++j) {
    const Vector3d turn = log_so3(T_G_base[j].R);
    if (!known[j] || turn.norm() < least_turn_rad) continue;
    directions += turn.normalized() * turn.normalized().transpose();
    const Matrix3d M = Matrix3d::Identity() - T_G_base[j].R;
    A += M.transpose() * M;
    b += M.transpose() * T_G_base[j].t;
  }
  if (directions.trace() == 0.0) return std::nullopt;
  TurningAxis axis;
  axis.direction = symmetric_eigen(directions).vectors.col(2);
  if (axis.direction.dot(about) < 0.0) axis.direction = -axis.direction;
  A += std::max(1.0, A.trace()) * axis.direction * axis.direction.transpose();
  axis.point = solve_symmetric3(A, b);
  axis.point -= axis.direction.dot(axis.point) * axis.direction;
  return axis;
}

}  // namespace rigcal
