#include "core/board/board_costs.h"

#include <ceres/sized_cost_function.h>

#include <Eigen/Eigenvalues>
#include <algorithm>

namespace rigcal::board {
namespace {

using RowMajor26 = Eigen::Matrix<double, 2, 6, Eigen::RowMajor>;
using RowMajor29 = Eigen::Matrix<double, 2, intrinsics_count, Eigen::RowMajor>;

class CornerCostFunction final : public ceres::SizedCostFunction<2, 6, 6, intrinsics_count> {
 public:
  explicit CornerCostFunction(const CornerCost& cost) : cost_(cost) {}

  bool Evaluate(const double* const* parameters, double* residuals, double** jacobians) const override {
    return cost_.evaluate(parameters, residuals, jacobians);
  }

 private:
  CornerCost cost_;
};

}  // namespace

bool CornerCost::evaluate(const double* const* parameters, double* residuals, double** jacobians) const {
  const Eigen::Map<const Vector6d> camera_x(parameters[0]);
  const Eigen::Map<const Vector6d> board_x(parameters[1]);
  // As `moved` and `moved_back` have it.
  const Vector3d turned = exp_so3(board_x.head<3>()) * corner;
  const Matrix3d& R_board = T_base_board->R;
  const Vector3d in_base = R_board * (turned + board_x.tail<3>()) + T_base_board->t;
  const Matrix3d back = exp_so3(-camera_x.head<3>());
  const Matrix3d to_start = T_base_camera->R.transpose();
  const Vector3d in_camera = back * (to_start * (in_base - T_base_camera->t) - camera_x.tail<3>());
  const CameraModel& model = camera->at(parameters[2]);
  PixelDerivatives by;
  const auto found = model.project(in_camera, by);
  if (!found) return false;
  const double weight = 1.0 / sigma_px;
  Eigen::Map<Eigen::Vector2d> off(residuals);
  off = weight * (*found - pixel);
  if (jacobians == nullptr) return true;
  const Eigen::Matrix<double, 2, 3> by_point = weight * by.by_point;
  if (jacobians[0] != nullptr) {
    Eigen::Map<RowMajor26> J(jacobians[0]);
    J.leftCols<3>() = by_point * skew(in_camera) * left_jacobian_so3(-camera_x.head<3>());
    J.rightCols<3>() = -by_point * back;
  }
  if (jacobians[1] != nullptr) {
    const Eigen::Matrix<double, 2, 3> by_start = by_point * back * to_start * R_board;
    Eigen::Map<RowMajor26> J(jacobians[1]);
    J.leftCols<3>() = -by_start * skew(turned) * left_jacobian_so3(board_x.head<3>());
    J.rightCols<3>() = by_start;
  }
  if (jacobians[2] != nullptr) {
    Eigen::Map<RowMajor29> J(jacobians[2]);
    J = weight * by.by_intrinsics;
  }
  return true;
}

ceres::CostFunction* corner_cost_function(const CornerCost& cost) { return new CornerCostFunction(cost); }

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
