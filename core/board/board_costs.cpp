#include "core/board/board_costs.h"

#include <Eigen/Eigenvalues>
#include <algorithm>

namespace rigcal::board {

std::array<double, intrinsics_count> ChangingCamera::values_of(const CameraIntrinsics& intrinsics) {
  std::array<double, intrinsics_count> values{intrinsics.fx, intrinsics.fy, intrinsics.cx, intrinsics.cy};
  for (std::size_t k = 0; k < std::min<std::size_t>(5, intrinsics.distortion.size()); ++k) {
    values[4 + k] = intrinsics.distortion[k];
  }
  return values;
}

CameraIntrinsics ChangingCamera::with_values(CameraIntrinsics intrinsics, const double* values) {
  intrinsics.fx = values[0];
  intrinsics.fy = values[1];
  intrinsics.cx = values[2];
  intrinsics.cy = values[3];
  intrinsics.distortion.assign(values + 4, values + 4 + distortion_count(intrinsics.model));
  return intrinsics;
}

const CameraModel& ChangingCamera::at(const double* values) const {
  if (!std::equal(values_.begin(), values_.end(), values)) {
    std::copy(values, values + values_.size(), values_.begin());
    model_ = CameraModel(with_values(intrinsics_, values));
  }
  return model_;
}

PlaneMoments7 plane_moments(const std::vector<Vector3d>& points) {
  using Matrix7 = Eigen::Matrix<double, 7, 7>;
  Matrix7 sum = Matrix7::Zero();
  for (const Vector3d& p : points) {
    Eigen::Matrix<double, 7, 1> v;
    v << p, 1.0, p.normalized();
    sum += v * v.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Matrix7> eigen(sum);
  PlaneMoments7 out;
  out.points = static_cast<double>(points.size());
  out.root = eigen.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal() * eigen.eigenvectors().transpose();
  return out;
}

}  // namespace rigcal::board
