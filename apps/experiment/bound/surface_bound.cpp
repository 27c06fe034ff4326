#include "apps/experiment/bound/surface_bound.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

#include "core/geometry/symmetric_eigen.h"

namespace rigcal::bound {
namespace {

// Beyond rounding; directions with less information than this part of the best are not known.
constexpr double least_information = 1e-12;

Matrix3d pseudo_inverse(const Matrix3d& A) {
  const SymmetricEigen eigen = symmetric_eigen(A);
  const double least = least_information * eigen.values[2];
  Vector3d inverse = Vector3d::Zero();
  for (int k = 0; k < 3; ++k) {
    if (eigen.values[k] > least) inverse[k] = 1.0 / eigen.values[k];
  }
  return eigen.vectors * inverse.asDiagonal() * eigen.vectors.transpose();
}

}  // namespace

double distance_variance(const SurfaceShot& shot) {
  const double r2 = shot.point.squaredNorm();
  const double along = shot.normal.dot(shot.point);
  const double cos2 = along * along / r2;
  return shot.range_variance * cos2 + r2 * shot.angle_variance * (1.0 - cos2) + shot.rounding_variance;
}

void add_shot(const SE3& T_G_sensor, const SurfaceShot& shot, ShotSums& sums) {
  Eigen::Matrix<double, 10, 1> J;
  J << shot.point.cross(shot.normal), shot.normal, T_G_sensor * shot.point, 1.0;
  sums.noalias() += J * J.transpose() / distance_variance(shot);
}

SurfaceBound::SurfaceBound(std::vector<SE3> T_base_sensor, std::vector<SE3> T_G_base, int base)
    : T_base_sensor_(std::move(T_base_sensor)), T_G_base_(std::move(T_G_base)), base_(base) {}

int SurfaceBound::add_plane(const Vector3d& normal_G, const Vector3d& point_G) {
  const Vector3d along = normal_G.unitOrthogonal();
  const Vector3d across = normal_G.cross(along);
  PlaneBasis basis = PlaneBasis::Zero();
  basis.col(0) << along, -along.dot(point_G);
  basis.col(1) << across, -across.dot(point_G);
  basis(3, 2) = -1.0;
  planes_.push_back(basis);
  seen_.emplace_back();
  return static_cast<int>(planes_.size()) - 1;
}

int SurfaceBound::lidar_index(int lidar) const { return lidar == base_ ? -1 : 6 * (lidar < base_ ? lidar : lidar - 1); }

// After those of the LiDARs.
int SurfaceBound::stop_index(int stop) const {
  return stop == 0 ? -1 : 6 * (static_cast<int>(T_base_sensor_.size()) - 1 + stop - 1);
}

void SurfaceBound::add(int lidar, int stop, int plane, const ShotSums& sums) {
  Eigen::Matrix<double, 10, 9> basis = Eigen::Matrix<double, 10, 9>::Zero();
  basis.topLeftCorner<6, 6>().setIdentity();
  basis.bottomRightCorner<4, 3>() = planes_[static_cast<std::size_t>(plane)];
  seen_[static_cast<std::size_t>(plane)].push_back({lidar, stop, basis.transpose() * sums * basis});
}

std::vector<std::optional<Matrix6d>> SurfaceBound::covariances() const {
  const auto lidars = static_cast<int>(T_base_sensor_.size());
  const int size = 6 * (lidars - 1 + static_cast<int>(T_G_base_.size()) - 1);
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(size, size);
  for (const std::vector<Patch>& patches : seen_) {
    Matrix3d own = Matrix3d::Zero();
    Eigen::MatrixXd with_rig = Eigen::MatrixXd::Zero(size, 3);
    for (const Patch& patch : patches) {
      // G exp(g) E exp(e): the pose's perturbation seen from the sensor.
      const Matrix6d chain = T_base_sensor_[static_cast<std::size_t>(patch.lidar)].inverse().adjoint();
      const int at_lidar = lidar_index(patch.lidar);
      const int at_stop = stop_index(patch.stop);
      const Matrix6d sensor = patch.sums.topLeftCorner<6, 6>();
      const Eigen::Matrix<double, 6, 3> cross = patch.sums.topRightCorner<6, 3>();
      own += patch.sums.bottomRightCorner<3, 3>();
      if (at_lidar >= 0) {
        A.block<6, 6>(at_lidar, at_lidar) += sensor;
        with_rig.middleRows<6>(at_lidar) += cross;
      }
      if (at_stop >= 0) {
        A.block<6, 6>(at_stop, at_stop) += chain.transpose() * sensor * chain;
        with_rig.middleRows<6>(at_stop) += chain.transpose() * cross;
      }
      if (at_lidar >= 0 && at_stop >= 0) {
        A.block<6, 6>(at_lidar, at_stop) += sensor * chain;
        A.block<6, 6>(at_stop, at_lidar) += chain.transpose() * sensor;
      }
    }
    A -= with_rig * pseudo_inverse(own) * with_rig.transpose();
  }
  std::vector<std::optional<Matrix6d>> out(T_base_sensor_.size());
  out[static_cast<std::size_t>(base_)] = Matrix6d::Zero();
  if (size == 0) return out;
  const Eigen::VectorXd ascending = symmetric_eigenvalues(A);
  if (ascending[0] <= least_information * ascending[size - 1]) return out;
  const Eigen::LDLT<Eigen::MatrixXd> factored(A);
  for (int i = 0; i < lidars; ++i) {
    const int at = lidar_index(i);
    if (at < 0) continue;
    Eigen::MatrixXd unit = Eigen::MatrixXd::Zero(size, 6);
    unit.middleRows<6>(at).setIdentity();
    const Eigen::MatrixXd columns = factored.solve(unit);
    out[static_cast<std::size_t>(i)] = columns.middleRows<6>(at);
  }
  return out;
}

}  // namespace rigcal::bound
