#include "core/start/signed_turns.h"

#include <cmath>

#include "core/geometry/symmetric_eigen.h"

namespace rigcal {

std::vector<std::optional<double>> signed_turns(const std::vector<std::optional<Matrix3d>>& R) {
  Matrix3d squares = Matrix3d::Zero();
  Vector3d sum = Vector3d::Zero();
  for (const std::optional<Matrix3d>& each : R) {
    if (!each) continue;
    const Vector3d turn = log_so3(*each);
    squares += turn * turn.transpose();
    sum += turn;
  }
  Vector3d axis = symmetric_eigen(squares).vectors.col(2);
  if (axis.dot(sum) < 0.0) axis = -axis;
  std::vector<std::optional<double>> turns(R.size());
  for (std::size_t j = 0; j < R.size(); ++j) {
    if (!R[j]) continue;
    const Vector3d turn = log_so3(*R[j]);
    turns[j] = std::copysign(turn.norm(), turn.dot(axis));
  }
  return turns;
}

}  // namespace rigcal
