#include "core/planes/range_errors.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

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

double mean_darkness(const PlaneFeature& feature) {
  double sum = 0.0;
  double weight = 0.0;
  for (std::size_t k = 0; k < feature.observations.size(); ++k) {
    const double w = feature.observations[k].weight * feature.observations[k].N;
    sum += w * feature.rays[k].darkness;
    weight += w;
  }
  return weight > 0.0 ? sum / weight : 0.0;
}

struct PoseCoupling {
  int index;
  std::array<Vector6d, 3> coupling;
};

class ErrorSum {
 public:
  ErrorSum(const RigState& state, const ParameterLayout& layout) : state_(state), layout_(layout) {}

  void add(const PlaneFeature& feature, RangeEquations& sum) {
    if (feature.rays.size() != feature.observations.size()) return;
    plane_derivatives(feature, state_, HessianForm::gauss_newton, plane_);
    poses_.clear();
    by_lidar_.assign(state_.T_base_sensor.size(), {});
    // All points of the plane move as those of a constant error do, for the black parameter by this as much.
    scale_ = {1.0, mean_darkness(feature)};
    for (std::size_t a = 0; a < feature.observations.size(); ++a) {
      add_observation(feature.observations[a], plane_.observations[a], feature.rays[a], sum);
    }
    const std::array<double, 3> factor{plane_.c0, plane_.c1, plane_.c2};
    for (int i = 0; i < layout_.lidars(); ++i) {
      for (std::size_t k = 0; k < 3; ++k) {
        const double scaled = factor[k] * by_lidar_[static_cast<std::size_t>(i)][k];
        if (scaled == 0.0) continue;
        for (const PoseCoupling& p : poses_) add_cross(p.index, i, scaled * p.coupling[k], sum);
        for (int j = 0; j < layout_.lidars(); ++j) {
          add_square(j, i, scaled * by_lidar_[static_cast<std::size_t>(j)][k], sum);
        }
      }
    }
  }

 private:
  void add_observation(const PlaneObservation& o, const ObservationDerivatives& d, const RayMoments& rays,
                       RangeEquations& sum) {
    const OffsetDerivatives b = derivatives_of(o, rays, state_, plane_);
    const auto i = static_cast<std::size_t>(o.lidar);
    sum.g[o.lidar] += scale_[0] * b.g;
    sum.g[layout_.lidars() + o.lidar] += scale_[1] * b.g;
    add_square(o.lidar, o.lidar, b.D, sum);
    for (std::size_t k = 0; k < 3; ++k) by_lidar_[i][k] += b.coupling[k];
    sum.weight[o.lidar] += o.weight * o.N;
    sum.darkness[o.lidar] += o.weight * o.N * rays.darkness;
    SE3 G = state_.T_G_base[static_cast<std::size_t>(o.stop)];
    G.t -= plane_.centroid;
    project(layout_.stop_index(o.stop), G.adjoint(), d, b, o.lidar, sum);
    project(layout_.lidar_index(o.lidar), (G * state_.T_base_sensor[i]).adjoint(), d, b, o.lidar, sum);
  }

  void project(int index, const Matrix6d& J, const ObservationDerivatives& d, const OffsetDerivatives& b, int lidar,
               RangeEquations& sum) {
    if (index < 0) return;
    add_cross(index, lidar, J.transpose() * b.D_pose, sum);
    poses_.push_back({index, {J.transpose() * d.beta, J.transpose() * d.eta1, J.transpose() * d.eta2}});
  }

  void add_cross(int index, int lidar, const Vector6d& value, RangeEquations& sum) const {
    sum.H_cross.block<6, 1>(index, lidar) += scale_[0] * value;
    sum.H_cross.block<6, 1>(index, layout_.lidars() + lidar) += scale_[1] * value;
  }

  void add_square(int i, int j, double value, RangeEquations& sum) const {
    const int L = layout_.lidars();
    for (int a = 0; a < 2; ++a) {
      for (int b = 0; b < 2; ++b) sum.H(a * L + i, b * L + j) += scale_[a] * scale_[b] * value;
    }
  }

  const RigState& state_;
  const ParameterLayout& layout_;
  PlaneDerivatives plane_;
  Eigen::Vector2d scale_ = Eigen::Vector2d::UnitX();  // of the parameters white and black on this plane
  std::vector<PoseCoupling> poses_;
  std::vector<std::array<double, 3>> by_lidar_;
};

double log_determinant(const Eigen::MatrixXd& A) {
  const Eigen::LLT<Eigen::MatrixXd> llt(A);
  return 2.0 * llt.matrixLLT().diagonal().array().log().sum();
}

double log_likelihood(const Eigen::VectorXd& estimate, const Eigen::MatrixXd& covariance) {
  return -0.5 * (estimate.dot(covariance.llt().solve(estimate)) + log_determinant(covariance));
}

// What is usual of all parameters before any plane was seen: with both kinds of errors white is the mean of what a
// LiDAR sees less its darkness times black.
Eigen::MatrixXd prior_covariance(const std::vector<double>& darkness, const RangePrior& prior, RangeLaw law) {
  const auto L = static_cast<Eigen::Index>(darkness.size());
  const Eigen::MatrixXd one = Eigen::MatrixXd::Identity(L, L);
  Eigen::MatrixXd C = Eigen::MatrixXd::Zero(2 * L, 2 * L);
  if (covers(law, RangeLaw::constant)) C.topLeftCorner(L, L) = prior.mean_m * prior.mean_m * one;
  if (!covers(law, RangeLaw::by_darkness)) return C;
  const Eigen::MatrixXd black =
      Eigen::MatrixXd::Constant(L, L, prior.black_m * prior.black_m) + prior.own_black_m * prior.own_black_m * one;
  C.bottomRightCorner(L, L) = black;
  if (law != RangeLaw::both) return C;
  const Eigen::MatrixXd by_black = Eigen::Map<const Eigen::VectorXd>(darkness.data(), L).asDiagonal() * -one;
  C.topLeftCorner(L, L) += by_black * black * by_black.transpose();
  C.topRightCorner(L, L) = by_black * black;
  C.bottomLeftCorner(L, L) = black * by_black.transpose();
  return C;
}

void add_law_error(Eigen::MatrixXd& covariance) {
  const Eigen::Index L = covariance.rows() / 2;
  covariance.topLeftCorner(L, L).array() += common_error_m * common_error_m;
  covariance.topLeftCorner(L, L).diagonal().array() += own_error_m * own_error_m;
}

bool has_rays(const std::vector<PlaneFeature>& features) {
  return !features.empty() && std::all_of(features.begin(), features.end(), [](const PlaneFeature& feature) {
    return feature.rays.size() == feature.observations.size();
  });
}

// What the data say of all parameters, with poses and extrinsics at their best for each.
struct ReducedEquations {
  Eigen::MatrixXd H;
  Eigen::VectorXd g;
};

// The step under a law, and its covariance. Nothing where the equations have no solution.
std::optional<RangeFit> fit_of(RangeLaw law, const ReducedEquations& data, const Eigen::VectorXd& taken_out,
                               const Eigen::MatrixXd& prior) {
  const Eigen::Index n = data.g.size();
  RangeFit fit;
  fit.step_m = Eigen::VectorXd::Zero(n);
  fit.covariance = Eigen::MatrixXd::Zero(n, n);
  if (law == RangeLaw::none) return fit;
  const Eigen::Index first = covers(law, RangeLaw::constant) ? 0 : n / 2;
  const Eigen::Index free = law == RangeLaw::both ? n : n / 2;
  const Eigen::MatrixXd one = Eigen::MatrixXd::Identity(free, free);
  const Eigen::MatrixXd held = 2.0 * prior.block(first, first, free, free).llt().solve(one);
  const Eigen::LLT<Eigen::MatrixXd> solver(data.H.block(first, first, free, free) + held);
  if (solver.info() != Eigen::Success) return std::nullopt;
  fit.step_m.segment(first, free) = -solver.solve(data.g.segment(first, free) + held * taken_out.segment(first, free));
  fit.covariance.block(first, first, free, free) = 2.0 * solver.solve(one);
  add_law_error(fit.covariance);
  return fit;
}

// Fits and likelihoods of all laws. False where the equations have no solution.
bool weigh_laws(const ReducedEquations& data, const Eigen::VectorXd& taken_out, const RangePrior& prior,
                RangeErrors& out) {
  // What the data alone say; where they say nothing a thousandth of what the prior says keeps it finite.
  const Eigen::MatrixXd one = Eigen::MatrixXd::Identity(data.H.rows(), data.H.cols());
  const Eigen::MatrixXd usual = prior_covariance(out.darkness, prior, RangeLaw::both);
  const Eigen::LLT<Eigen::MatrixXd> alone(data.H + 0.001 * 2.0 * usual.llt().solve(one));
  if (alone.info() != Eigen::Success) return false;
  const Eigen::VectorXd estimate = taken_out - alone.solve(data.g);
  Eigen::MatrixXd noise = 2.0 * alone.solve(one);
  add_law_error(noise);
  std::array<double, all_range_laws.size()> logs{};
  for (const RangeLaw law : all_range_laws) {
    const auto k = static_cast<std::size_t>(law);
    const Eigen::MatrixXd of_law = prior_covariance(out.darkness, prior, law);
    std::optional<RangeFit> fit = fit_of(law, data, taken_out, of_law);
    if (!fit) return false;
    out.fits[k] = std::move(*fit);
    logs[k] = log_likelihood(estimate, noise + of_law);
  }
  const double most = *std::max_element(logs.begin(), logs.end());
  double sum = 0.0;
  for (const double each : logs) sum += std::exp(each - most);
  for (std::size_t k = 0; k < logs.size(); ++k) out.fits[k].likely = std::exp(logs[k] - most) / sum;
  return true;
}

}  // namespace

RangeError RangeFit::step_of(int lidar) const { return {step_m[lidar], step_m[step_m.size() / 2 + lidar]}; }

double RangeFit::variance_at(int lidar, double darkness) const {
  const Eigen::Index black = covariance.rows() / 2 + lidar;
  return covariance(lidar, lidar) + 2.0 * darkness * covariance(lidar, black) +
         darkness * darkness * covariance(black, black);
}

double RangeErrors::likely_covering(RangeLaw law) const {
  double sum = 0.0;
  for (const RangeLaw each : all_range_laws) sum += covers(each, law) ? fit(each).likely : 0.0;
  return sum;
}

RangeEquations& RangeEquations::operator+=(const RangeEquations& other) {
  g += other.g;
  H += other.H;
  H_cross += other.H_cross;
  weight += other.weight;
  darkness += other.darkness;
  return *this;
}

RangeEquations build_range_equations(const std::vector<PlaneFeature>& features, const RigState& state,
                                     const ParameterLayout& layout) {
  const int n = layout.size();
  const int L = layout.lidars();
  const RangeEquations zero{Eigen::VectorXd::Zero(2 * L), Eigen::MatrixXd::Zero(2 * L, 2 * L),
                            Eigen::MatrixXd::Zero(n, 2 * L), Eigen::VectorXd::Zero(L), Eigen::VectorXd::Zero(L)};
  return parallel_sum(features.size(), grain, zero, [&](std::size_t begin, std::size_t end) {
    RangeEquations part = zero;
    ErrorSum sum(state, layout);
    for (std::size_t i = begin; i < end; ++i) sum.add(features[i], part);
    return part;
  });
}

RangeErrors find_range_errors(const std::vector<PlaneFeature>& features, const RigState& state,
                              const ParameterLayout& layout, const AdjustOptions& options,
                              const std::vector<RangeError>& taken_out, const RangePrior& prior) {
  RangeErrors out;
  const int L = layout.lidars();
  if (layout.size() == 0 || !has_rays(features)) return out;
  NormalEquations poses = build_normal_equations(features, state, layout, HessianForm::gauss_newton);
  add_priors(layout, options, state, poses);
  // A LiDAR or stop on no plane says nothing, and nothing about the others' ranges.
  for (Eigen::Index i = 0; i < poses.H.rows(); ++i) {
    if (poses.H(i, i) == 0.0) poses.H(i, i) = 1.0;
  }
  const Eigen::LLT<Eigen::MatrixXd> llt(poses.H);
  if (llt.info() != Eigen::Success) return out;
  const RangeEquations equations = build_range_equations(features, state, layout);
  Eigen::VectorXd already = Eigen::VectorXd::Zero(equations.g.size());
  for (int i = 0; i < L; ++i) {
    out.darkness.push_back(equations.weight[i] > 0.0 ? equations.darkness[i] / equations.weight[i] : 0.0);
    if (taken_out.empty()) continue;
    already[i] = taken_out[static_cast<std::size_t>(i)].white_m;
    already[L + i] = taken_out[static_cast<std::size_t>(i)].black_m;
  }
  out.shift = -llt.solve(equations.H_cross);
  const ReducedEquations data{equations.H + equations.H_cross.transpose() * out.shift,
                              equations.g + out.shift.transpose() * poses.g};
  out.known = weigh_laws(data, already, prior, out);
  return out;
}

}  // namespace rigcal
