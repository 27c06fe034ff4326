#include "core/board/closed_form.h"

#include "core/geometry/symmetric_eigen.h"
#include "core/geometry/symmetric_solve.h"

namespace rigcal {
namespace {

// Normals nearer to one direction, or to one plane, than this (mean square of the sine) leave the answer to noise.
constexpr double least_spread = 1e-3;

Vector3d normal_spread(std::span<const BoardPair> pairs) {
  Matrix3d sum = Matrix3d::Zero();
  for (const BoardPair& pair : pairs) sum += pair.a.normal * pair.a.normal.transpose();
  return symmetric_eigen(sum / static_cast<double>(pairs.size())).values;
}

// Rigid motion of all 4N corners of b onto those of a (Kabsch). Of one board at least.
SE3 motion_by_corners(std::span<const BoardPair> pairs) {
  const double count = 4.0 * static_cast<double>(pairs.size());
  Vector3d mean_a = Vector3d::Zero();
  Vector3d mean_b = Vector3d::Zero();
  for (const BoardPair& pair : pairs) {
    for (std::size_t k = 0; k < 4; ++k) {
      mean_a += pair.a.corners[k] / count;
      mean_b += pair.b.corners[k] / count;
    }
  }
  Matrix3d sum = Matrix3d::Zero();
  for (const BoardPair& pair : pairs) {
    for (std::size_t k = 0; k < 4; ++k) {
      sum += (pair.a.corners[k] - mean_a) * (pair.b.corners[k] - mean_b).transpose();
    }
  }
  const Matrix3d R = nearest_rotation(sum);
  return {R, mean_a - R * mean_b};
}

}  // namespace

BoardPair::Side board_side(const SE3& T_sensor_board, const std::array<Vector3d, 4>& plate_corners) {
  BoardPair::Side side;
  side.normal = T_sensor_board.R.col(2);
  side.distance = side.normal.dot(T_sensor_board.t);
  for (std::size_t k = 0; k < 4; ++k) side.corners[k] = T_sensor_board * plate_corners[k];
  return side;
}

std::optional<Matrix3d> rotation_by_normals(std::span<const BoardPair> pairs) {
  if (pairs.size() < 2 || normal_spread(pairs)[1] < least_spread) return std::nullopt;
  Matrix3d sum = Matrix3d::Zero();
  for (const BoardPair& pair : pairs) sum += pair.a.normal * pair.b.normal.transpose();
  return nearest_rotation(sum);
}

std::optional<Vector3d> translation_by_planes(std::span<const BoardPair> pairs, const Matrix3d& R_a_b) {
  if (pairs.size() < 3 || normal_spread(pairs)[0] < least_spread) return std::nullopt;
  Matrix3d A = Matrix3d::Zero();
  Vector3d y = Vector3d::Zero();
  for (const BoardPair& pair : pairs) {
    for (const Vector3d& corner : pair.b.corners) {
      A += pair.a.normal * pair.a.normal.transpose();
      y += pair.a.normal * (pair.a.distance - pair.a.normal.dot(R_a_b * corner));
    }
  }
  return solve_symmetric3(A, y);
}

std::optional<ClosedForm> closed_form(std::span<const BoardPair> pairs) {
  if (pairs.empty()) return std::nullopt;
  ClosedForm out;
  if (const auto R = rotation_by_normals(pairs)) {
    if (const auto t = translation_by_planes(pairs, *R)) out.by_planes = SE3{*R, *t};
  }
  out.T_a_b = motion_by_corners(pairs);
  return out;
}

}  // namespace rigcal
