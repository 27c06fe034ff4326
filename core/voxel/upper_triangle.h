#pragma once

#include <Eigen/Core>

#include "core/geometry/se3.h"

namespace rigcal {

/// A symmetric 3 x 3 matrix by its upper triangle: xx xy xz yy yz zz.
using UpperTriangle = Eigen::Matrix<double, 6, 1>;

[[nodiscard]] inline Matrix3d full(const UpperTriangle& s) {
  Matrix3d S;
  S << s[0], s[1], s[2], s[1], s[3], s[4], s[2], s[4], s[5];
  return S;
}

/// u^T S u.
[[nodiscard]] inline double along(const UpperTriangle& s, const Vector3d& u) {
  return s[0] * u.x() * u.x() + s[3] * u.y() * u.y() + s[5] * u.z() * u.z() +
         2.0 * (s[1] * u.x() * u.y() + s[2] * u.x() * u.z() + s[4] * u.y() * u.z());
}

/// sum += w d d^T
inline void add_square(double w, const Vector3d& d, UpperTriangle& sum) {
  sum[0] += w * d.x() * d.x();
  sum[1] += w * d.x() * d.y();
  sum[2] += w * d.x() * d.z();
  sum[3] += w * d.y() * d.y();
  sum[4] += w * d.y() * d.z();
  sum[5] += w * d.z() * d.z();
}

}  // namespace rigcal
