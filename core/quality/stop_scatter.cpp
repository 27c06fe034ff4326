#include "core/quality/stop_scatter.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <cmath>

#include "core/base/parallel.h"
#include "core/geometry/symmetric_eigen.h"
#include "core/planes/lever.h"

namespace rigcal {
namespace {

struct StopSums {
  Eigen::MatrixXd moves;   // of all LiDARs (six rows each), a column for each stop
  Eigen::MatrixXd weight;  // by the offsets' variances, a row for each LiDAR

  StopSums& operator+=(const StopSums& other) {
    moves += other.moves;
    weight += other.weight;
    return *this;
  }
};

class StopSum {
 public:
  /// `rows`: those of the LiDARs in the inverse Hessian.
  StopSum(const RigState& state, const ParameterLayout& layout, const Eigen::MatrixXd& rows)
      : state_(state), layout_(layout), rows_(rows) {}

  void add(const PlaneFeature& feature, StopSums& sum) {
    plane_derivatives(feature, state_, HessianForm::gauss_newton, plane_);
    // How the LiDARs move where the plane does: along its normal, and tilted either way.
    ByPlane by_plane = ByPlane::Zero(rows_.rows(), 3);
    for (std::size_t a = 0; a < feature.observations.size(); ++a) {
      const PlaneObservation& o = feature.observations[a];
      const SE3& G = state_.T_G_base[static_cast<std::size_t>(o.stop)];
      add_pose(G, layout_.stop_index(o.stop), a, by_plane, sum.moves.col(o.stop));
      add_pose(G * state_.T_base_sensor[static_cast<std::size_t>(o.lidar)], layout_.lidar_index(o.lidar), a, by_plane,
               sum.moves.col(o.stop));
    }
    const Vector3d across1 = plane_.tangent1.cross(plane_.normal);
    const Vector3d across2 = plane_.tangent2.cross(plane_.normal);
    for (std::size_t a = 0; a < feature.observations.size(); ++a) {
      const PlaneObservation& o = feature.observations[a];
      const Vector6d& g = plane_.observations[a].g;
      // Half of what the observation adds to the cost's gradient by the plane, over what holds the plane.
      const Vector3d pull(0.5 * plane_.c0 * g.tail<3>().dot(plane_.normal), 0.5 * plane_.c1 * g.head<3>().dot(across1),
                          0.5 * plane_.c2 * g.head<3>().dot(across2));
      sum.moves.col(o.stop) += by_plane * pull;
      if (o.offset_variance > 0.0) sum.weight(o.lidar, o.stop) += 1.0 / o.offset_variance;
    }
  }

 private:
  using ByPlane = Eigen::Matrix<double, Eigen::Dynamic, 3>;

  // Of the pose whose six stand at `index`; below zero: it is fixed.
  void add_pose(const SE3& T_G_pose, int index, std::size_t observation, ByPlane& by_plane,
                Eigen::Ref<Eigen::VectorXd> moves) const {
    if (index < 0) return;
    const Lever lever(T_G_pose, plane_.centroid);
    const ObservationDerivatives& d = plane_.observations[observation];
    Eigen::Matrix<double, 6, 3> coupling;
    coupling << lever.of(d.beta), lever.of(d.eta1), lever.of(d.eta2);
    by_plane += rows_.middleCols<6>(index) * coupling;
    moves += rows_.middleCols<6>(index) * lever.of(d.g);
  }

  const RigState& state_;
  const ParameterLayout& layout_;
  const Eigen::MatrixXd& rows_;
  PlaneDerivatives plane_;
};

StopSums sum_stops(const std::vector<PlaneFeature>& features, const RigState& state, const ParameterLayout& layout,
                   const Eigen::MatrixXd& inverse_hessian) {
  constexpr std::size_t grain = 256;
  const int lidars = layout.lidars();
  // What is fixed does not move.
  Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(6 * lidars, layout.size());
  for (int i = 0; i < lidars; ++i) {
    const int index = layout.lidar_index(i);
    if (index >= 0) rows.middleRows<6>(6 * i) = inverse_hessian.middleRows<6>(index);
  }
  const StopSums none{Eigen::MatrixXd::Zero(6 * lidars, layout.stops()), Eigen::MatrixXd::Zero(lidars, layout.stops())};
  return parallel_sum(features.size(), grain, none, [&](std::size_t begin, std::size_t end) {
    StopSums part = none;
    StopSum sum(state, layout, rows);
    for (std::size_t k = begin; k < end; ++k) sum.add(features[k], part);
    return part;
  });
}

// So many that say equally much.
double equal_stops(const Eigen::VectorXd& weights) {
  const double squares = weights.squaredNorm();
  return squares > 0.0 ? weights.sum() * weights.sum() / squares : 0.0;
}

// Of the largest eigenvalue of a covariance that was estimated from so many samples less one, over the true one, in
// three dimensions: exceeded by chance in one of a hundred (Johnstone, On the distribution of the largest eigenvalue
// in principal components analysis, 2001: its centre and width; Tracy and Widom's first law).
double largest_by_chance(double degrees) {
  constexpr double one_of_a_hundred = 2.02;
  const double a = std::sqrt(degrees - 0.5);
  const double b = std::sqrt(3.0 - 0.5);
  const double centre = (a + b) * (a + b);
  const double width = (a + b) * std::cbrt(1.0 / a + 1.0 / b);
  return (centre + one_of_a_hundred * width) / degrees;
}

double scatter_of(const Matrix3d& seen, const Matrix3d& covariance, double stops) {
  const Eigen::LLT<Matrix3d> root(covariance);
  if (root.info() != Eigen::Success || !seen.allFinite()) return 1.0;
  const Matrix3d half = root.matrixL().solve(seen);
  const Matrix3d white = root.matrixL().solve(half.transpose());
  const double largest = symmetric_eigen(Matrix3d(0.5 * (white + white.transpose()))).values[2];
  return largest > largest_by_chance(stops - 1.0) ? largest : 1.0;
}

}  // namespace

StopMoves stop_moves(const std::vector<PlaneFeature>& features, const RigState& state, const ParameterLayout& layout,
                     const Eigen::MatrixXd& inverse_hessian, std::optional<int> base) {
  const StopSums sums = sum_stops(features, state, layout, inverse_hessian);
  StopMoves out;
  for (int i = 0; i < layout.lidars(); ++i) {
    out.moves.emplace_back(sums.moves.middleRows<6>(6 * i));
    out.stops.push_back(equal_stops(sums.weight.row(i)));
    if (!base) continue;
    // T_b_i = T_b T_i^-1, each with its own exp(x) on the right.
    const auto at = [&](int lidar) { return state.T_base_sensor[static_cast<std::size_t>(lidar)]; };
    out.moves.back() -= (at(i).inverse() * at(*base)).adjoint() * sums.moves.middleRows<6>(6 * *base);
  }
  return out;
}

StopScatter stop_scatter(const Eigen::Matrix<double, 6, Eigen::Dynamic>& moves, double stops,
                         const Matrix6d& covariance) {
  if (!(stops >= least_scattering_stops) || !covariance.allFinite()) return {};
  const Eigen::Matrix<double, 6, Eigen::Dynamic> apart = moves.colwise() - moves.rowwise().mean();
  const Matrix6d seen = stops / (stops - 1.0) * apart * apart.transpose();
  return {scatter_of(seen.topLeftCorner<3, 3>(), covariance.topLeftCorner<3, 3>(), stops),
          scatter_of(seen.bottomRightCorner<3, 3>(), covariance.bottomRightCorner<3, 3>(), stops)};
}

Matrix6d widened(const Matrix6d& covariance, const StopScatter& scatter) {
  Vector6d by;
  by << Vector3d::Constant(std::sqrt(scatter.turn)), Vector3d::Constant(std::sqrt(scatter.place));
  return by.asDiagonal() * covariance * by.asDiagonal();
}

}  // namespace rigcal
