#include "core/corner/three_planes.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <cmath>
#include <utility>

#include "core/base/text.h"

namespace rigcal {
namespace {

Matrix3d rows_of(const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  Matrix3d rows;
  rows << a.transpose(), b.transpose(), c.transpose();
  return rows;
}

Matrix3d normals_of(const ThreePlanes& planes) { return rows_of(planes[0].normal, planes[1].normal, planes[2].normal); }

Error not_independent(const ThreePlanes& planes) {
  double least_deg = 90.0;
  for (std::size_t i = 0; i < 3; ++i) {
    const double cosine = std::abs(planes[i].normal.dot(planes[(i + 1) % 3].normal));
    least_deg = std::min(least_deg, to_deg(std::acos(std::min(1.0, cosine))));
  }
  return input_error(
      "the three planes are nearly parallel to one line or to each other (the least angle between two "
      "is " +
          fixed_text(least_deg, 1) + " degrees)",
      {}, "show a corner: three surfaces that face clearly different ways");
}

}  // namespace

double independence(const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  return Eigen::JacobiSVD<Matrix3d>(rows_of(a, b, c)).singularValues()[2];
}

Expected<Vector3d> intersection(const ThreePlanes& planes) {
  if (independence(planes[0].normal, planes[1].normal, planes[2].normal) < least_independence) {
    return not_independent(planes);
  }
  const Vector3d offsets(planes[0].offset_m, planes[1].offset_m, planes[2].offset_m);
  return Vector3d(normals_of(planes).partialPivLu().solve(offsets));
}

ThreePlanes with_oriented_normals(ThreePlanes planes, const Vector3d& o) {
  const Vector3d shares = normals_of(planes).transpose().partialPivLu().solve(-o);
  for (int k = 0; k < 3; ++k) {
    FittedPlane& plane = planes[static_cast<std::size_t>(k)];
    if (shares[k] < 0.0) plane = plane.flipped();
  }
  return planes;
}

ThreePlanes in_order(ThreePlanes planes, const Vector3d& up) {
  for (std::size_t k = 0; k < 2; ++k) {
    if (std::abs(planes[k].normal.dot(up)) > std::abs(planes[2].normal.dot(up))) std::swap(planes[k], planes[2]);
  }
  if (planes[1].normal.cross(planes[0].normal).dot(planes[2].normal) < 0.0) std::swap(planes[0], planes[1]);
  return planes;
}

Expected<Corner> make_corner(const ThreePlanes& planes, const Vector3d& up) {
  const Expected<Vector3d> o = intersection(planes);
  if (!o) return o.error();
  return Corner{in_order(with_oriented_normals(planes, *o), up), *o};
}

SE3 corner_alignment(const Corner& a, const Corner& b) {
  Matrix3d sum = Matrix3d::Zero();
  for (std::size_t k = 0; k < 3; ++k) sum += a.planes[k].normal * b.planes[k].normal.transpose();
  const Matrix3d R = nearest_rotation(sum);
  return {R, a.point - R * b.point};
}

}  // namespace rigcal
