#pragma once

#include <Eigen/Geometry>

#include "core/geometry/se3.h"

namespace rigcal {

/// A pose as seen from a plane's centroid, m: carries what a plane's derivatives have by left twists [phi; tau] about
/// that point (PlaneDerivatives) to right perturbations [rotation; translation] of the pose.
struct Lever {
  Matrix3d Rt;  ///< Of the pose's rotation the transpose.
  Vector3d t;   ///< From the centroid, world frame.

  Lever(const SE3& T, const Vector3d& centroid) : Rt(T.R.transpose()), t(T.t - centroid) {}

  /// Ad^T v; v is [by phi; by tau], the result [by rotation; by translation].
  [[nodiscard]] Vector6d of(const Vector6d& v) const {
    Vector6d out;
    out << Rt * (v.head<3>() - t.cross(v.tail<3>())), Rt * v.tail<3>();
    return out;
  }
};

}  // namespace rigcal
