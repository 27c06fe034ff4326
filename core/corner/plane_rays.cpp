#include "core/corner/plane_rays.h"

#include <Eigen/Cholesky>
#include <cmath>

#include "core/geometry/symmetric_eigen.h"

namespace rigcal {
namespace {

constexpr double near_sigmas = 4.0;
constexpr double least_points = 10.0;

// By those of the LiDAR's points that lie on the plane where the observation is.
RayMoments rays_of(const PlaneObservation& o, const std::vector<Vector3d>& points) {
  const SymmetricEigen eigen = symmetric_eigen(o.scatter);
  const Vector3d normal = eigen.vectors.col(0);
  const Eigen::Matrix<double, 3, 2> along = eigen.vectors.rightCols<2>();
  const Eigen::Vector2d scatter = eigen.values.tail<2>().cwiseMax(0.0);
  const Eigen::Vector2d half_size = (3.0 / o.N * scatter).cwiseSqrt();  // of an even rectangle
  double N = 0.0;
  Eigen::Vector2d sum_x = Eigen::Vector2d::Zero();
  Vector3d sum_d = Vector3d::Zero();
  Eigen::Matrix2d sum_xx = Eigen::Matrix2d::Zero();
  Eigen::Matrix<double, 2, 3> sum_xd = Eigen::Matrix<double, 2, 3>::Zero();
  for (const Vector3d& p : points) {
    const Eigen::Vector2d x = along.transpose() * (p - o.mean);
    const bool is_beside = std::abs(x[0]) > half_size[0] || std::abs(x[1]) > half_size[1];
    if (is_beside || std::abs(normal.dot(p - o.mean)) > near_sigmas / std::sqrt(o.weight)) continue;
    const Vector3d d = p.normalized();
    N += 1.0;
    sum_x += x;
    sum_d += d;
    sum_xx += x * x.transpose();
    sum_xd += x * d.transpose();
  }
  RayMoments rays;
  rays.mean = o.mean.normalized();
  if (N < least_points) return rays;
  rays.mean = sum_d / N;
  sum_xx -= sum_x * sum_x.transpose() / N;
  sum_xd -= sum_x * sum_d.transpose() / N;
  const Eigen::LLT<Eigen::Matrix2d> solver(sum_xx);
  if (solver.info() != Eigen::Success) return rays;
  const Eigen::Matrix<double, 2, 3> slope = solver.solve(sum_xd);
  rays.cross = along * scatter.asDiagonal() * slope;
  rays.scatter = slope.transpose() * scatter.asDiagonal() * slope;
  return rays;
}

}  // namespace

void add_rays(const RigViews& views, std::vector<PlaneFeature>& features) {
  for (PlaneFeature& feature : features) {
    feature.rays.clear();
    for (const PlaneObservation& o : feature.observations) {
      const auto& view = views.stops[static_cast<std::size_t>(o.stop)][static_cast<std::size_t>(o.lidar)];
      feature.rays.push_back(rays_of(o, view->cloud.points));
    }
  }
}

}  // namespace rigcal
