#pragma once

#include "core/geometry/se3.h"

namespace rigcal {

/// What a set of points leaves behind for plane fitting: N, v = sum p, P = sum p p^T, all about the origin of the
/// frame the points stand in (architecture: the points themselves are read once and forgotten). Weights enter as a
/// factor on all three.
struct PointCluster {
  double N = 0.0;
  Vector3d v = Vector3d::Zero();
  Matrix3d P = Matrix3d::Zero();

  void add(const Vector3d& p) {
    N += 1.0;
    v += p;
    P.noalias() += p * p.transpose();
  }
  PointCluster& operator+=(const PointCluster& other) {
    N += other.N;
    v += other.v;
    P += other.P;
    return *this;
  }
  [[nodiscard]] Vector3d mean() const { return v / N; }
  /// Covariance of the points, P/N - mean mean^T.
  [[nodiscard]] Matrix3d covariance() const;
  /// The cluster of the points p' = R p + t: P' = R P R^T + R v t^T + t (R v)^T + N t t^T, v' = R v + N t.
  [[nodiscard]] PointCluster transformed(const SE3& T) const;
  /// The cluster of the points p' = p + shift.
  [[nodiscard]] PointCluster shifted(const Vector3d& shift) const;
  /// All sums times `weight`.
  [[nodiscard]] PointCluster scaled(double weight) const { return {weight * N, weight * v, weight * P}; }
};

}  // namespace rigcal
