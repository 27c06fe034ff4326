#include "core/geometry/se3.h"

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

namespace rigcal {
namespace {

// sin(a)/a, (1 - cos a)/a^2 and (a - sin a)/a^3, by series where the quotients would lose digits.
struct Coefficients {
  double a, b, c;
};

Coefficients coefficients(double angle) {
  const double x = angle * angle;
  if (x < 1e-4) {
    return {1.0 - x / 6.0 * (1.0 - x / 20.0), 0.5 - x / 24.0 * (1.0 - x / 30.0),
            1.0 / 6.0 - x / 120.0 * (1.0 - x / 42.0)};
  }
  return {std::sin(angle) / angle, (1.0 - std::cos(angle)) / x, (angle - std::sin(angle)) / (x * angle)};
}

}  // namespace

Matrix3d skew(const Vector3d& a) {
  Matrix3d m;
  m << 0.0, -a.z(), a.y(), a.z(), 0.0, -a.x(), -a.y(), a.x(), 0.0;
  return m;
}

Matrix3d exp_so3(const Vector3d& phi) {
  const Coefficients k = coefficients(phi.norm());
  const Matrix3d s = skew(phi);
  return Matrix3d::Identity() + k.a * s + k.b * s * s;
}

Vector3d log_so3(const Matrix3d& R) {
  const Eigen::Quaterniond q(R);
  const double n = q.vec().norm();
  // The quaternion is stable everywhere; atan2 with w >= 0 keeps the angle in [0, pi].
  const double sign = q.w() < 0.0 ? -1.0 : 1.0;
  if (n < 1e-12) return sign * 2.0 * q.vec();
  return (2.0 * std::atan2(n, sign * q.w()) * sign / n) * q.vec();
}

Matrix3d left_jacobian_so3(const Vector3d& phi) {
  const Coefficients k = coefficients(phi.norm());
  const Matrix3d s = skew(phi);
  return Matrix3d::Identity() + k.b * s + k.c * s * s;
}

Matrix3d nearest_rotation(const Matrix3d& M) {
  const Eigen::JacobiSVD<Matrix3d> svd(M, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Vector3d signs(1.0, 1.0, 1.0);
  if (svd.matrixU().determinant() * svd.matrixV().determinant() < 0.0) signs.z() = -1.0;
  return svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
}

Matrix3d turn_onto(const Vector3d& from, const Vector3d& to) {
  return Eigen::Quaterniond::FromTwoVectors(from, to).toRotationMatrix();
}

Matrix3d rotation_from_xyzw(const Eigen::Vector4d& xyzw) {
  return Eigen::Quaterniond(xyzw[3], xyzw[0], xyzw[1], xyzw[2]).normalized().toRotationMatrix();
}

Eigen::Vector4d xyzw_from_rotation(const Matrix3d& R) {
  Eigen::Quaterniond q(R);
  q.normalize();
  if (q.w() < 0.0) q.coeffs() = -q.coeffs();
  return q.coeffs();
}

Eigen::Matrix4d SE3::matrix() const {
  Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
  m.topLeftCorner<3, 3>() = R;
  m.topRightCorner<3, 1>() = t;
  return m;
}

SE3 SE3::exp(const Vector6d& xi) {
  const Vector3d phi = xi.head<3>();
  return {exp_so3(phi), left_jacobian_so3(phi) * xi.tail<3>()};
}

Vector6d SE3::log() const {
  Vector6d xi;
  const Vector3d phi = log_so3(R);
  xi.head<3>() = phi;
  xi.tail<3>() = left_jacobian_so3(phi).inverse() * t;
  return xi;
}

Matrix6d SE3::adjoint() const {
  Matrix6d ad = Matrix6d::Zero();
  ad.topLeftCorner<3, 3>() = R;
  ad.bottomRightCorner<3, 3>() = R;
  ad.bottomLeftCorner<3, 3>() = skew(t) * R;
  return ad;
}

double rotation_distance(const Matrix3d& a, const Matrix3d& b) { return log_so3(a * b.transpose()).norm(); }

}  // namespace rigcal
