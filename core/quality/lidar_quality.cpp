#include "core/quality/lidar_quality.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/text.h"
#include "core/planes/range_offsets.h"

namespace rigcal {
namespace {

double largest(const Matrix3d& C) { return Eigen::SelfAdjointEigenSolver<Matrix3d>(C).eigenvalues()[2]; }

// Of all free parameters.
struct FullCovariances {
  Eigen::MatrixXd with_priors;
  Eigen::MatrixXd data_only;
};

// T_b_i = T_b T_i^-1, each with its own exp(x) on the right: T_b_i exp(x_i - Ad(T_i_b) x_b).
std::vector<Matrix6d> blocks_of(const Eigen::MatrixXd& covariance, const SolvedPlanes& solved,
                                std::optional<int> base) {
  const ParameterLayout& layout = solved.layout;
  const std::vector<SE3>& T = solved.state.T_base_sensor;
  std::vector<Matrix6d> out(static_cast<std::size_t>(layout.lidars()), Matrix6d::Zero());
  const int of_base = base ? layout.lidar_index(*base) : -1;
  for (int i = 0; i < layout.lidars(); ++i) {
    if (of_base >= 0 && i == *base) continue;
    const auto si = static_cast<std::size_t>(i);
    const int index = layout.lidar_index(i);
    if (index >= 0) out[si] = covariance.block<6, 6>(index, index);
    if (of_base < 0) continue;
    const Matrix6d A = (T[si].inverse() * T[static_cast<std::size_t>(*base)]).adjoint();
    out[si] += A * covariance.block<6, 6>(of_base, of_base) * A.transpose();
    if (index < 0) continue;
    const Matrix6d cross = A * covariance.block<6, 6>(of_base, index);
    out[si] -= cross + cross.transpose();
  }
  return out;
}

// The inverse of H with directions of (almost) no information held at a variance that nobody takes for knowledge.
Eigen::MatrixXd inverse_information(const Eigen::MatrixXd& H) {
  const Eigen::VectorXd scale = H.diagonal().cwiseMax(1e-12).cwiseSqrt().cwiseInverse();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(scale.asDiagonal() * H * scale.asDiagonal());
  const Eigen::VectorXd values = solver.eigenvalues().cwiseMax(1e-12).cwiseInverse();
  const Eigen::MatrixXd inverse = solver.eigenvectors() * values.asDiagonal() * solver.eigenvectors().transpose();
  return scale.asDiagonal() * inverse * scale.asDiagonal();
}

// What shapes alone hold is known to decimetres at best, whatever the scatter of the match says: where only upright
// walls are seen, the borders of what was seen decide upon the height.
AdjustOptions with_honest_matches(AdjustOptions options) {
  constexpr double floor_m = 0.06;
  for (std::optional<PosePrior>& match : options.lidar_matches) {
    if (!match) continue;
    Matrix6d covariance = match->information.inverse();
    covariance.diagonal().tail<3>().array() += floor_m * floor_m;
    match->information = covariance.inverse();
  }
  return options;
}

// Half of a pose: where it is, or how it is turned.
enum class Half { turn, place };

// Of the pose whose six start at `at`.
template <class Covariance>
auto half_of(Covariance& C, Half half, int at = 0) {
  const int first = half == Half::place ? at + 3 : at;
  return C.template block<3, 3>(first, first);
}

// By how much planes hold one direction of a LiDAR's place or turn.
struct Hold {
  double all = 0.0;     ///< 1 / m^2 or 1 / rad^2, up to a factor that all planes share.
  double facing = 0.0;  ///< Of these from planes that face it, or stand aslant to the way a turn moves them.
};

// Of every LiDAR along its own direction `axes[i]`; directions of zero length are passed over.
std::vector<Hold> holds_along(const SolvedPlanes& solved, Half half, const std::vector<Vector3d>& axes) {
  // What noise tilts small leaves by, and no more; turns are held by far ones, which are larger and tilted less.
  const double facing_cos = half == Half::place ? 0.1 : 0.05;
  std::vector<Hold> holds(axes.size());
  PlaneDerivatives plane;
  for (const PlaneFeature& feature : solved.features) {
    plane_derivatives(feature, solved.state, HessianForm::gauss_newton, plane);
    for (const PlaneObservation& o : feature.observations) {
      const auto i = static_cast<std::size_t>(o.lidar);
      if (axes[i].isZero() || !(o.offset_variance > 0.0)) continue;
      const Vector3d normal = solved.state.T_G_sensor(o.stop, o.lidar).R.transpose() * plane.normal;
      const auto add = [&](double cosine, double information) {
        holds[i].all += information;
        if (std::abs(cosine) > facing_cos) holds[i].facing += information;
      };
      if (half == Half::place) {
        const double cosine = normal.dot(axes[i]);
        add(cosine, cosine * cosine / o.offset_variance);
        continue;
      }
      // By its distance, and by how far it reaches about its mean.
      const double off = normal.dot(axes[i].cross(o.mean));
      const Vector3d tilt = normal.cross(axes[i]);
      add(off / std::max(o.mean.norm(), 1e-3), off * off / o.offset_variance);
      add(tilt.norm(), tilt.dot(o.scatter * tilt) / (o.N * o.offset_variance));
    }
  }
  return holds;
}

// One axis of the covariances' halves, `rank` from the widest; of the LiDARs in `open`. Those that are not held along
// it are widened and stay in `open`.
void widen_axis(const SolvedPlanes& solved, const AdjustOptions& held, Half half, int rank, std::vector<char>& open,
                FullCovariances& full, LidarCovariances& out) {
  constexpr double least_share = 0.5;
  const double widest = half == Half::place ? 2.0 : 1.0;  // m, rad
  std::vector<Vector3d> axes(open.size(), Vector3d::Zero());
  for (std::size_t i = 0; i < open.size(); ++i) {
    if (!open[i]) continue;
    const Matrix3d C = half_of(full.with_priors, half, solved.layout.lidar_index(static_cast<int>(i)));
    axes[i] = Eigen::SelfAdjointEigenSolver<Matrix3d>(C).eigenvectors().col(2 - rank);
  }
  const std::vector<Hold> holds = holds_along(solved, half, axes);
  for (std::size_t i = 0; i < open.size(); ++i) {
    open[i] = open[i] && holds[i].facing < least_share * holds[i].all;
    if (!open[i]) continue;
    double by_match = 0.0;
    if (i < held.lidar_matches.size() && held.lidar_matches[i]) {
      Matrix6d C = held.lidar_matches[i]->information.inverse();
      by_match = 1.0 / axes[i].dot(half_of(C, half) * axes[i]);
    }
    for (Eigen::MatrixXd* covariance : {&full.with_priors, &full.data_only}) {
      auto part = half_of(*covariance, half, solved.layout.lidar_index(static_cast<int>(i)));
      const double variance = axes[i].dot(part * axes[i]);
      const double by_planes = std::max(0.0, 1.0 / variance - by_match) * holds[i].facing / holds[i].all;
      const double honest = std::min(1.0 / std::max(by_planes + by_match, 1e-9), widest * widest);
      if (half == Half::place && rank == 0 && by_match > by_planes) out.only_matched[i] = axes[i];
      part += std::max(0.0, honest - variance) * axes[i] * axes[i].transpose();
    }
  }
}

// Noise tilts the normals of leaves by a degree or two, and thousands of walls so tilted seem to hold the height that
// none of them faces (in a court of walls: to 7 mm, where it was 90 mm off). What does not face the worst direction of
// a LiDAR's place or turn does not count there, where that is most of what holds it; nor then for the next direction.
void widen_open_directions(const SolvedPlanes& solved, const AdjustOptions& held, FullCovariances& full,
                           LidarCovariances& out) {
  out.only_matched.assign(static_cast<std::size_t>(solved.layout.lidars()), Vector3d::Zero());
  for (const Half half : {Half::place, Half::turn}) {
    std::vector<char> open;
    for (int i = 0; i < solved.layout.lidars(); ++i) open.push_back(solved.layout.lidar_index(i) >= 0 ? 1 : 0);
    for (int rank = 0; rank < 3 && std::count(open.begin(), open.end(), 1) > 0; ++rank) {
      widen_axis(solved, held, half, rank, open, full, out);
    }
  }
}

// What the ranges may be off by, as far as the planes do not tell it, moves every LiDAR along its view. Where nothing
// was taken out: as likely as it is that there is something, and then by what it seems to be.
void widen_by_range_offsets(const SolvedPlanes& solved, const AdjustOptions& held, double factor, FullCovariances& full,
                            LidarCovariances& out) {
  const RangeOffsets offsets =
      find_range_offsets(solved.features, solved.state, solved.layout, held, {}, solved.range_offset_m);
  if (!offsets.known) return;
  Eigen::MatrixXd of_offsets = factor * offsets.covariance;
  if (!solved.ranges_corrected) {
    of_offsets += offsets.step_m * offsets.step_m.transpose();
    of_offsets *= offsets.likely;
  }
  for (Eigen::Index i = 0; i < of_offsets.rows(); ++i) out.range_sigma_m.push_back(std::sqrt(of_offsets(i, i)));
  const Eigen::MatrixXd wider = offsets.shift * of_offsets * offsets.shift.transpose();
  full.with_priors += wider;
  full.data_only += wider;
}

// Who is held out: every fourth of the stops that LiDARs saw, or with fewer than four of them every fifth plane.
class HeldOut {
 public:
  HeldOut(const SolvedPlanes& solved, int base)
      : base_(base), place_(static_cast<std::size_t>(solved.layout.stops()), -1) {
    for (const PlaneFeature& feature : solved.features) {
      for (const PlaneObservation& o : feature.observations) place_[static_cast<std::size_t>(o.stop)] = 0;
    }
    for (int& place : place_) {
      if (place == 0) place = stops_++;
    }
  }

  [[nodiscard]] bool operator()(std::size_t feature, const PlaneObservation& o) const {
    if (o.lidar == base_) return false;
    return stops_ >= 4 ? place_[static_cast<std::size_t>(o.stop)] % 4 == 2 : feature % 5 == 2;
  }

 private:
  int base_;
  std::vector<int> place_;  ///< Of each stop among those that LiDARs saw; -1: it is not.
  int stops_ = 0;
};

// Of what an observation is off its plane by, from how well poses and extrinsics are known (`C`, of all that is free):
// a stop that only the base placed may be loose along what the base does not face.
double pose_variance(const SolvedPlanes& solved, const Eigen::MatrixXd& C, const RigState& state,
                     const PlaneObservation& o, const Vector3d& normal) {
  const SE3& T_base_sensor = state.T_base_sensor[static_cast<std::size_t>(o.lidar)];
  const auto along = [&](const Vector3d& p, const Matrix3d& R) {
    const Vector3d n = R.transpose() * normal;
    Vector6d J;
    J << p.cross(n), n;
    return J;
  };
  const Matrix3d& R_G_base = state.T_G_base[static_cast<std::size_t>(o.stop)].R;
  const std::array<Vector6d, 2> J{along(T_base_sensor * o.mean, R_G_base), along(o.mean, R_G_base * T_base_sensor.R)};
  const std::array<int, 2> at{solved.layout.stop_index(o.stop), solved.layout.lidar_index(o.lidar)};
  double variance = 0.0;
  for (std::size_t a = 0; a < 2; ++a) {
    for (std::size_t b = 0; b < 2; ++b) {
      if (at[a] >= 0 && at[b] >= 0) variance += J[a].dot(C.block<6, 6>(at[a], at[b]) * J[b]);
    }
  }
  return std::max(0.0, variance);
}

// Of poses and extrinsics by some of the planes.
Eigen::MatrixXd covariance_by(const std::vector<PlaneFeature>& features, const SolvedPlanes& solved,
                              const RigState& state) {
  if (solved.layout.size() == 0) return {};
  NormalEquations sum = build_normal_equations(features, state, solved.layout, HessianForm::gauss_newton);
  add_priors(solved.layout, solved.adjust, state, sum);
  return 2.0 * inverse_information(sum.H);
}

struct OffsetSums {
  std::vector<double> squares, normalised, count;
  explicit OffsetSums(std::size_t lidars) : squares(lidars), normalised(lidars), count(lidars) {}
};

}  // namespace

double mean_square_offset(const std::vector<PlaneFeature>& features, const RigState& state, int parameters) {
  double squares = 0.0;
  double degrees = -static_cast<double>(parameters);
  for (const PlaneFeature& feature : features) {
    if (feature.merged) continue;
    for_each_offset(feature, state, [&](const PlaneObservation& o, double e, double freedom) {
      squares += e * e / o.offset_variance;
      degrees += freedom;
    });
  }
  return degrees > 0.0 ? squares / degrees : 0.0;
}

LidarCovariances lidar_covariances(const SolvedPlanes& solved, std::optional<int> base) {
  LidarCovariances out;
  const int n = solved.layout.size();
  if (n == 0 || solved.features.empty()) return out;
  NormalEquations sum = build_normal_equations(solved.features, solved.state, solved.layout, HessianForm::gauss_newton);
  out.chi2 = mean_square_offset(solved.features, solved.state, n);
  const double factor = 2.0 * std::max(1.0, out.chi2);
  NormalEquations data = sum;
  const AdjustOptions held = with_honest_matches(solved.adjust);
  add_matches(solved.layout, held, solved.state, data);
  FullCovariances full;
  full.data_only = factor * inverse_information(data.H);
  add_priors(solved.layout, held, solved.state, sum);
  const Eigen::LLT<Eigen::MatrixXd> llt(sum.H);
  out.observable = llt.info() == Eigen::Success;
  full.with_priors = factor * inverse_information(sum.H);
  if (solved.range_offset_m > 0.0) widen_by_range_offsets(solved, held, 0.5 * factor, full, out);
  // Given poses and guesses hold what they hold.
  if (solved.adjust.lidar_priors.empty()) widen_open_directions(solved, held, full, out);
  out.with_priors = blocks_of(full.with_priors, solved, base);
  out.data_only = blocks_of(full.data_only, solved, base);
  return out;
}

HoldOut hold_out(const SolvedPlanes& solved, int base, const std::vector<SE3>& guess) {
  const auto lidars = static_cast<std::size_t>(solved.layout.lidars());
  HoldOut out;
  out.normalised.assign(lidars, 0.0);
  out.rms_m.assign(lidars, 0.0);
  out.start_rms_m.assign(lidars, 0.0);
  const HeldOut is_held_out(solved, base);
  std::vector<PlaneFeature> kept;
  for (std::size_t k = 0; k < solved.features.size(); ++k) {
    PlaneFeature feature = solved.features[k];
    std::erase_if(feature.observations, [&](const PlaneObservation& o) { return is_held_out(k, o); });
    if (feature.observations.size() >= 2) kept.push_back(std::move(feature));
  }
  RigState state = solved.state;
  adjust(kept, solved.layout, solved.adjust, state);
  out.T_base_sensor = state.T_base_sensor;
  RigState at_guess = state;
  for (std::size_t i = 0; i < std::min(lidars, guess.size()); ++i) at_guess.T_base_sensor[i] = guess[i];

  const Eigen::MatrixXd C = covariance_by(kept, solved, state);
  OffsetSums sums(lidars);
  OffsetSums start(lidars);
  PlaneDerivatives derivatives;
  for (std::size_t k = 0; k < solved.features.size(); ++k) {
    if (solved.features[k].merged) continue;
    PlaneFeature rest = solved.features[k];
    std::erase_if(rest.observations, [&](const PlaneObservation& o) { return is_held_out(k, o); });
    // A plane of one patch is too short a lever to predict another's place.
    if (rest.observations.size() < 2 || rest.observations.size() == solved.features[k].observations.size()) continue;
    plane_derivatives(rest, state, HessianForm::gauss_newton, derivatives);
    for (const PlaneObservation& o : solved.features[k].observations) {
      if (!is_held_out(k, o)) continue;
      const auto i = static_cast<std::size_t>(o.lidar);
      const Vector3d p = state.T_G_sensor(o.stop, o.lidar) * o.mean;
      const double e = derivatives.normal.dot(p - derivatives.centroid);
      // The plane's own uncertainty where it is met: its offset and its tilt times the distance from its middle.
      const double m1 = (p - derivatives.centroid - e * derivatives.normal).squaredNorm();
      const double plane = 1.0 / derivatives.N + m1 / (derivatives.N * std::max(derivatives.eigenvalues[1], 1e-6));
      sums.squares[i] += e * e;
      const double by_poses = pose_variance(solved, C, state, o, derivatives.normal);
      sums.normalised[i] += e * e / (o.offset_variance + plane + by_poses);
      sums.count[i] += 1.0;
      const Vector3d p0 = at_guess.T_G_sensor(o.stop, o.lidar) * o.mean;
      start.squares[i] += std::pow(derivatives.normal.dot(p0 - derivatives.centroid), 2);
    }
  }
  for (std::size_t i = 0; i < lidars; ++i) {
    if (sums.count[i] < 6.0) continue;
    out.normalised[i] = std::sqrt(sums.normalised[i] / sums.count[i]);
    out.rms_m[i] = std::sqrt(sums.squares[i] / sums.count[i]);
    out.start_rms_m[i] = std::sqrt(start.squares[i] / sums.count[i]);
  }
  return out;
}

std::string direction_words(Vector3d d) {
  int axis = 0;
  d.cwiseAbs().maxCoeff(&axis);
  if (d[axis] < 0.0) d = -d;
  constexpr double as_good_as_axis = 0.966;  // within 15 degrees
  constexpr std::array<const char*, 3> axes{"x (forwards)", "y (sideways)", "z (up and down)"};
  if (d[axis] > as_good_as_axis) return axes[static_cast<std::size_t>(axis)] + std::string(" of the base frame");
  return "(" + fixed_text(d.x(), 2) + ", " + fixed_text(d.y(), 2) + ", " + fixed_text(d.z(), 2) + ") of the base frame";
}

std::string weak_translation_words(const Matrix6d& covariance, const SE3& T_base_sensor) {
  const Matrix3d C = covariance.bottomRightCorner<3, 3>();
  return direction_words(T_base_sensor.R * Eigen::SelfAdjointEigenSolver<Matrix3d>(C).eigenvectors().col(2));
}

double translation_bound(const Matrix6d& covariance) {
  return std::sqrt(chi2_95_3 * std::max(0.0, largest(covariance.bottomRightCorner<3, 3>())));
}

double rotation_bound(const Matrix6d& covariance) {
  return std::sqrt(chi2_95_3 * std::max(0.0, largest(covariance.topLeftCorner<3, 3>())));
}

}  // namespace rigcal
