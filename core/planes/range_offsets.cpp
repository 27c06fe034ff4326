#include "core/planes/range_offsets.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/parallel.h"

namespace rigcal {
namespace {

constexpr std::size_t grain = 128;

// What a wrong noise law does to all offsets alike, and to each on its own.
constexpr double common_error_m = 0.002;
constexpr double own_error_m = 0.0005;

// Derivatives of one observation with respect to its LiDAR's offset b, p -> p - b d: the distance of a point to the
// plane changes by -u.d. Names as in ObservationDerivatives.
struct OffsetDerivatives {
  double g = 0.0;
  double D = 0.0;
  std::array<double, 3> coupling{};    // beta, eta1, eta2
  Vector6d D_pose = Vector6d::Zero();  // against [phi; tau]
};

OffsetDerivatives derivatives_of(const PlaneObservation& o, const RayMoments& rays, const RigState& state,
                                 const PlaneDerivatives& plane) {
  const SE3 T = state.T_G_sensor(o.stop, o.lidar);
  const Vector3d& u = plane.normal;
  const Vector3d u_sensor = T.R.transpose() * u;
  const double N = o.weight * o.N;
  const double cosine = u_sensor.dot(rays.mean);
  // sum (p - q)(u.d)
  const Vector3d Pu = o.weight * (T.R * (rays.cross * u_sensor)) + N * cosine * (T * o.mean - plane.centroid);
  OffsetDerivatives out;
  out.g = -2.0 * u.dot(Pu);
  out.D = 2.0 * (o.weight * u_sensor.dot(rays.scatter * u_sensor) + N * cosine * cosine);
  out.coupling = {-N * cosine, -plane.tangent1.dot(Pu), -plane.tangent2.dot(Pu)};
  out.D_pose << -2.0 * Pu.cross(u), -2.0 * N * cosine * u;
  return out;
}

struct PoseCoupling {
  int index;
  std::array<Vector6d, 3> coupling;
};

class OffsetSum {
 public:
  OffsetSum(const RigState& state, const ParameterLayout& layout) : state_(state), layout_(layout) {}

  void add(const PlaneFeature& feature, OffsetEquations& sum) {
    if (feature.rays.size() != feature.observations.size()) return;
    plane_derivatives(feature, state_, HessianForm::gauss_newton, plane_);
    poses_.clear();
    by_lidar_.assign(state_.T_base_sensor.size(), {});
    for (std::size_t a = 0; a < feature.observations.size(); ++a) {
      add_observation(feature.observations[a], plane_.observations[a], feature.rays[a], sum);
    }
    const std::array<double, 3> factor{plane_.c0, plane_.c1, plane_.c2};
    for (std::size_t i = 0; i < by_lidar_.size(); ++i) {
      const auto column = static_cast<Eigen::Index>(i);
      for (std::size_t k = 0; k < 3; ++k) {
        const double scaled = factor[k] * by_lidar_[i][k];
        if (scaled == 0.0) continue;
        for (const PoseCoupling& p : poses_) sum.H_cross.block<6, 1>(p.index, column) += scaled * p.coupling[k];
        for (std::size_t j = 0; j < by_lidar_.size(); ++j) {
          sum.H(static_cast<Eigen::Index>(j), column) += scaled * by_lidar_[j][k];
        }
      }
    }
  }

 private:
  void add_observation(const PlaneObservation& o, const ObservationDerivatives& d, const RayMoments& rays,
                       OffsetEquations& sum) {
    const OffsetDerivatives b = derivatives_of(o, rays, state_, plane_);
    const auto i = static_cast<std::size_t>(o.lidar);
    sum.g[o.lidar] += b.g;
    sum.H(o.lidar, o.lidar) += b.D;
    for (std::size_t k = 0; k < 3; ++k) by_lidar_[i][k] += b.coupling[k];
    SE3 G = state_.T_G_base[static_cast<std::size_t>(o.stop)];
    G.t -= plane_.centroid;
    project(layout_.stop_index(o.stop), G.adjoint(), d, b, o.lidar, sum);
    project(layout_.lidar_index(o.lidar), (G * state_.T_base_sensor[i]).adjoint(), d, b, o.lidar, sum);
  }

  void project(int index, const Matrix6d& J, const ObservationDerivatives& d, const OffsetDerivatives& b, int lidar,
               OffsetEquations& sum) {
    if (index < 0) return;
    sum.H_cross.block<6, 1>(index, lidar) += J.transpose() * b.D_pose;
    poses_.push_back({index, {J.transpose() * d.beta, J.transpose() * d.eta1, J.transpose() * d.eta2}});
  }

  const RigState& state_;
  const ParameterLayout& layout_;
  PlaneDerivatives plane_;
  std::vector<PoseCoupling> poses_;
  std::vector<std::array<double, 3>> by_lidar_;
};

double log_determinant(const Eigen::MatrixXd& A) {
  const Eigen::LLT<Eigen::MatrixXd> llt(A);
  return 2.0 * llt.matrixLLT().diagonal().array().log().sum();
}

// Estimates without a prior are N(0, noise) where there are no offsets, N(0, noise + prior^2) where there are.
double likelihood_of_offsets(const Eigen::VectorXd& estimate, const Eigen::MatrixXd& noise, double prior_m) {
  Eigen::MatrixXd with = noise;
  with.diagonal().array() += prior_m * prior_m;
  const double chance = estimate.dot(noise.llt().solve(estimate)) + log_determinant(noise);
  const double offsets = estimate.dot(with.llt().solve(estimate)) + log_determinant(with);
  return 1.0 / (1.0 + std::exp(std::clamp(0.5 * (offsets - chance), -700.0, 700.0)));
}

void add_law_error(Eigen::MatrixXd& covariance) {
  covariance.array() += common_error_m * common_error_m;
  covariance.diagonal().array() += own_error_m * own_error_m;
}

bool has_rays(const std::vector<PlaneFeature>& features) {
  return !features.empty() && std::all_of(features.begin(), features.end(), [](const PlaneFeature& feature) {
    return feature.rays.size() == feature.observations.size();
  });
}

}  // namespace

OffsetEquations& OffsetEquations::operator+=(const OffsetEquations& other) {
  g += other.g;
  H += other.H;
  H_cross += other.H_cross;
  return *this;
}

OffsetEquations build_offset_equations(const std::vector<PlaneFeature>& features, const RigState& state,
                                       const ParameterLayout& layout) {
  const int n = layout.size();
  const int L = layout.lidars();
  const OffsetEquations zero{Eigen::VectorXd::Zero(L), Eigen::MatrixXd::Zero(L, L), Eigen::MatrixXd::Zero(n, L)};
  return parallel_sum(features.size(), grain, zero, [&](std::size_t begin, std::size_t end) {
    OffsetEquations part = zero;
    OffsetSum sum(state, layout);
    for (std::size_t i = begin; i < end; ++i) sum.add(features[i], part);
    return part;
  });
}

RangeOffsets find_range_offsets(const std::vector<PlaneFeature>& features, const RigState& state,
                                const ParameterLayout& layout, const AdjustOptions& options,
                                const std::vector<double>& taken_out_m, double prior_m) {
  RangeOffsets out;
  const int n = layout.size();
  if (n == 0 || !has_rays(features)) return out;
  NormalEquations poses = build_normal_equations(features, state, layout, HessianForm::gauss_newton);
  add_priors(layout, options, state, poses);
  const Eigen::LLT<Eigen::MatrixXd> llt(poses.H);
  if (llt.info() != Eigen::Success) return out;
  OffsetEquations offsets = build_offset_equations(features, state, layout);
  const double prior = 2.0 / (prior_m * prior_m);
  for (int i = 0; i < layout.lidars(); ++i) {
    offsets.H(i, i) += prior;
    if (!taken_out_m.empty()) offsets.g[i] += prior * taken_out_m[static_cast<std::size_t>(i)];
  }
  out.shift = -llt.solve(offsets.H_cross);
  const Eigen::MatrixXd S = offsets.H + offsets.H_cross.transpose() * out.shift;
  const Eigen::LLT<Eigen::MatrixXd> schur(S);
  if (schur.info() != Eigen::Success) return out;
  out.step_m = -schur.solve(offsets.g + out.shift.transpose() * poses.g);
  out.covariance = 2.0 * schur.solve(Eigen::MatrixXd::Identity(S.rows(), S.cols()));
  // What the data alone say; where they say nothing a little of the prior keeps it finite.
  const Eigen::MatrixXd one = Eigen::MatrixXd::Identity(S.rows(), S.cols());
  const Eigen::LLT<Eigen::MatrixXd> data(S - 0.999 * prior * one);
  if (data.info() != Eigen::Success) return out;
  Eigen::MatrixXd noise = 2.0 * data.solve(one);
  add_law_error(noise);
  out.likely = likelihood_of_offsets(data.solve(S * out.step_m), noise, prior_m);
  add_law_error(out.covariance);
  out.known = true;
  return out;
}

}  // namespace rigcal
