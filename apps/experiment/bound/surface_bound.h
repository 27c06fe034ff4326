#pragma once

#include <optional>
#include <vector>

#include "core/geometry/se3.h"

namespace rigcal::bound {

/// A shot whose surface is known. Everything is the truth: neither noise nor estimate.
struct SurfaceShot {
  Vector3d point = Vector3d::Zero();    ///< Sensor frame.
  Vector3d normal = Vector3d::UnitX();  ///< Unit, of its plane, sensor frame; the same side for all shots on a plane.
  double range_variance = 0.0;          ///< Of the range, m^2,
  double angle_variance = 0.0;          ///< of the direction in each of two directions across it, rad^2,
  double rounding_variance = 0.0;       ///< and of each coordinate once more, m^2: the wire's whole millimetres.
};

/// The variance of the measured point's distance to the plane: sigma_r^2 cos^2 i + r^2 sigma_angle^2 sin^2 i +
/// rounding.
[[nodiscard]] double distance_variance(const SurfaceShot& shot);

/// Sums over the shots of one LiDAR at one stop on one plane of J^T J / s^2, for the distance's derivatives by the
/// sensor's pose (right, six), the plane's normal (three, by the point in G) and its offset.
using ShotSums = Eigen::Matrix<double, 10, 10>;
void add_shot(const SE3& T_G_sensor, const SurfaceShot& shot, ShotSums& sums);

/// The Cramer-Rao bound of the extrinsics of LiDARs from shots on planes, when somebody tells which shot lies on which
/// plane, and what noise each has, and nothing else: the planes (three parameters each) and the poses of the stops (six
/// each, but for the first) are unknown, and so is where each shot really went.
///
/// A shot measures its range r and its direction d (two angles) with independent noise. Its true direction is a
/// parameter of its own; eliminating it leaves one residual, the distance e = n.(G_j E_i p - c) of the measured point
/// to the plane, with variance s^2 = sigma_r^2 cos^2 i + r^2 sigma_angle^2 sin^2 i + rounding (to first order in the
/// noise; that the variances themselves depend on the parameters a little is not used). With J = de/d(extrinsics E,
/// poses G, planes) the information is A = sum J^T J / s^2, and the bound the block of E in its inverse, which is that
/// of the Schur complement A_EE - A_EN A_NN^-1 A_NE over all nuisances N. No unbiased estimator that goes by where
/// points lie across flat surfaces does better; edges of surfaces and curved ones could add to it.
class SurfaceBound {
 public:
  /// True extrinsics and poses; `base` has the rig's frame and is not estimated, nor is the first stop.
  SurfaceBound(std::vector<SE3> T_base_sensor, std::vector<SE3> T_G_base, int base);

  /// Numbers planes from 0 on. `normal_G` has length 1.
  int add_plane(const Vector3d& normal_G, const Vector3d& point_G);

  /// Once for each patch and plane.
  void add(int lidar, int stop, int plane, const ShotSums& sums);

  /// Of xi = [rotation rad; translation m] in T_base_sensor exp(xi), for each LiDAR; zero for the base, nothing where
  /// the shots do not tell.
  [[nodiscard]] std::vector<std::optional<Matrix6d>> covariances() const;

 private:
  /// Two turns of the plane about a point of it, and its shift, in the sums' four.
  using PlaneBasis = Eigen::Matrix<double, 4, 3>;
  struct Patch {
    int lidar;
    int stop;
    Eigen::Matrix<double, 9, 9> sums;
  };
  [[nodiscard]] int lidar_index(int lidar) const;
  [[nodiscard]] int stop_index(int stop) const;

  std::vector<SE3> T_base_sensor_;
  std::vector<SE3> T_G_base_;
  int base_;
  std::vector<PlaneBasis> planes_;
  std::vector<std::vector<Patch>> seen_;  ///< By plane.
};

}  // namespace rigcal::bound
