#include "core/geometry/point_cluster.h"

namespace rigcal {

Matrix3d PointCluster::covariance() const {
  const Vector3d q = v / N;
  return P / N - q * q.transpose();
}

PointCluster PointCluster::transformed(const SE3& T) const {
  PointCluster out;
  const Vector3d Rv = T.R * v;
  out.N = N;
  out.v = Rv + N * T.t;
  const Matrix3d cross = Rv * T.t.transpose();
  out.P = T.R * P * T.R.transpose() + cross + cross.transpose() + N * T.t * T.t.transpose();
  return out;
}

PointCluster PointCluster::shifted(const Vector3d& shift) const {
  PointCluster out;
  out.N = N;
  out.v = v + N * shift;
  const Matrix3d cross = v * shift.transpose();
  out.P = P + cross + cross.transpose() + N * shift * shift.transpose();
  return out;
}

}  // namespace rigcal
