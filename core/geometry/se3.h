#pragma once

#include <Eigen/Core>

namespace rigcal {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

constexpr double pi = 3.14159265358979323846;
[[nodiscard]] constexpr double to_deg(double rad) { return rad * 180.0 / pi; }
[[nodiscard]] constexpr double to_rad(double deg) { return deg * pi / 180.0; }

/// The cross-product matrix: skew(a) b = a x b.
[[nodiscard]] Matrix3d skew(const Vector3d& a);

/// Rotation by |phi| rad about phi (Rodrigues); exact to rounding also near zero.
[[nodiscard]] Matrix3d exp_so3(const Vector3d& phi);
/// The rotation vector of R, |phi| in [0, pi]. At pi one of the two equal answers.
[[nodiscard]] Vector3d log_so3(const Matrix3d& R);
/// Left Jacobian of SO(3): exp(phi + d) = exp(J d) exp(phi) to first order.
[[nodiscard]] Matrix3d left_jacobian_so3(const Vector3d& phi);
/// The rotation nearest to M in the Frobenius norm.
[[nodiscard]] Matrix3d nearest_rotation(const Matrix3d& M);
/// The smallest rotation that turns the direction of `from` to that of `to`; where they are opposite, one of the half
/// turns.
[[nodiscard]] Matrix3d turn_onto(const Vector3d& from, const Vector3d& to);
/// From a quaternion [x, y, z, w] of any length but zero, and back (unit, w >= 0).
[[nodiscard]] Matrix3d rotation_from_xyzw(const Eigen::Vector4d& xyzw);
[[nodiscard]] Eigen::Vector4d xyzw_from_rotation(const Matrix3d& R);

/// A rigid motion. `T_a_b` maps coordinates in frame b into frame a: p_a = R p_b + t.
struct SE3 {
  Matrix3d R = Matrix3d::Identity();
  Vector3d t = Vector3d::Zero();

  [[nodiscard]] SE3 operator*(const SE3& other) const { return {R * other.R, R * other.t + t}; }
  [[nodiscard]] Vector3d operator*(const Vector3d& p) const { return R * p + t; }
  [[nodiscard]] SE3 inverse() const { return {R.transpose(), -(R.transpose() * t)}; }
  [[nodiscard]] Eigen::Matrix4d matrix() const;

  /// Exponential of xi = [rotation rad; translation m]. States are updated on the right: T exp(xi).
  [[nodiscard]] static SE3 exp(const Vector6d& xi);
  [[nodiscard]] Vector6d log() const;
  /// Ad with T exp(xi) T^-1 = exp(Ad xi), in the order [rotation; translation].
  [[nodiscard]] Matrix6d adjoint() const;
};

/// The angle of a.R b.R^T in rad, in [0, pi].
[[nodiscard]] double rotation_distance(const Matrix3d& a, const Matrix3d& b);

}  // namespace rigcal
