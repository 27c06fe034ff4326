#include "core/quality/lidar_quality.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/base/text.h"
#include "core/geometry/chi_square.h"
#include "core/geometry/matrix6.h"
#include "core/geometry/symmetric_eigen.h"
#include "core/quality/inverse_information.h"

namespace rigcal {
namespace {

// Nothing can be said of what is no number.
double largest(const Matrix3d& C) {
  if (!C.allFinite()) return std::numeric_limits<double>::quiet_NaN();
  return std::max(symmetric_eigen(C).values[2], 0.0);
}

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

// Each by itself, so that one that is not held does not speak against the others. Where it cannot be
// inverted, one is held where all its directions hold 1e-8 of what they would if nothing else could move.
std::vector<char> observable_lidars(const Eigen::MatrixXd& H, const Eigen::MatrixXd& covariance,
                                    const ParameterLayout& layout, std::optional<int> base) {
  constexpr double widest = 1e8;
  const bool is_invertible = Eigen::LLT<Eigen::MatrixXd>(H).info() == Eigen::Success;
  const auto is_held = [&](int lidar) {
    const int index = layout.lidar_index(lidar);
    if (index < 0) return true;
    const Vector6d scale = H.diagonal().segment<6>(index).cwiseMax(0.0).cwiseSqrt();
    const Matrix6d scaled = scale.asDiagonal() * covariance.block<6, 6>(index, index) * scale.asDiagonal();
    if (!scaled.allFinite()) return false;
    if (is_invertible) return true;
    if (scale.minCoeff() == 0.0) return false;
    return symmetric_eigen6(scaled).values[5] < widest;
  };
  std::vector<char> out;
  const bool is_base_held = !base || is_held(*base);
  for (int i = 0; i < layout.lidars(); ++i) out.push_back(is_base_held && is_held(i) ? 1 : 0);
  return out;
}

// What shapes alone hold is known to decimetres at best, whatever the scatter of the match says: where only upright
// walls are seen, the borders of what was seen decide upon the height.
AdjustOptions with_honest_matches(AdjustOptions options) {
  constexpr double floor_m = 0.06;
  for (std::optional<PosePrior>& match : options.lidar_matches) {
    if (!match) continue;
    Matrix6d covariance = inverse6(match->information);
    covariance.diagonal().tail<3>().array() += floor_m * floor_m;
    match->information = inverse6(covariance);
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

// What noise tilts small leaves by, and no more; turns are held by far ones, which are larger and tilted less.
constexpr double facing_cos_of_place = 0.1;
constexpr double facing_cos_of_turn = 0.05;

// Of one plane, what one LiDAR's observations sum to along a direction: weight * cosine, weight * cosine^2.
struct PlaceSums {
  Eigen::Vector2d all = Eigen::Vector2d::Zero();
  Eigen::Vector2d facing = Eigen::Vector2d::Zero();
};

// A plane stands where all who see it say: where a LiDAR alone sees it, and from all stops alike (a floor, and the
// height), it goes with the LiDAR and holds nothing.
void add_place_holds(const SolvedPlanes& solved, const PlaneFeature& feature, const Vector3d& normal_G,
                     const std::vector<Vector3d>& axes, std::vector<Hold>& holds) {
  std::vector<PlaceSums> sums(axes.size());
  double all_weight = 0.0;
  for (const PlaneObservation& o : feature.observations) {
    if (!(o.offset_variance > 0.0)) continue;
    const auto i = static_cast<std::size_t>(o.lidar);
    const double weight = 1.0 / o.offset_variance;
    const double cosine = axes[i].dot(solved.state.T_G_sensor(o.stop, o.lidar).R.transpose() * normal_G);
    all_weight += weight;
    sums[i].all += weight * Eigen::Vector2d(cosine, cosine * cosine);
    if (std::abs(cosine) > facing_cos_of_place) sums[i].facing += weight * Eigen::Vector2d(cosine, cosine * cosine);
  }
  // Once the plane's own offset is solved for.
  const auto left_of = [&](const Eigen::Vector2d& sum) { return std::max(0.0, sum[1] - sum[0] * sum[0] / all_weight); };
  for (std::size_t i = 0; i < axes.size() && all_weight > 0.0; ++i) {
    holds[i].all += left_of(sums[i].all);
    holds[i].facing += left_of(sums[i].facing);
  }
}

void add_turn_holds(const SolvedPlanes& solved, const PlaneFeature& feature, const Vector3d& normal_G,
                    const std::vector<Vector3d>& axes, std::vector<Hold>& holds) {
  for (const PlaneObservation& o : feature.observations) {
    const auto i = static_cast<std::size_t>(o.lidar);
    if (axes[i].isZero() || !(o.offset_variance > 0.0)) continue;
    const Vector3d normal = solved.state.T_G_sensor(o.stop, o.lidar).R.transpose() * normal_G;
    const auto add = [&](double cosine, double information) {
      holds[i].all += information;
      if (std::abs(cosine) > facing_cos_of_turn) holds[i].facing += information;
    };
    // By its distance, and by how far it reaches about its mean.
    const double off = normal.dot(axes[i].cross(o.mean));
    const Vector3d tilt = normal.cross(axes[i]);
    add(off / std::max(o.mean.norm(), 1e-3), off * off / o.offset_variance);
    add(tilt.norm(), tilt.dot(o.scatter * tilt) / (o.N * o.offset_variance));
  }
}

// Of every LiDAR along its own direction `axes[i]`; directions of zero length are passed over.
std::vector<Hold> holds_along(const SolvedPlanes& solved, Half half, const std::vector<Vector3d>& axes) {
  std::vector<Hold> holds(axes.size());
  PlaneDerivatives plane;
  for (const PlaneFeature& feature : solved.features) {
    plane_derivatives(feature, solved.state, HessianForm::gauss_newton, plane);
    const auto add_holds = half == Half::place ? add_place_holds : add_turn_holds;
    add_holds(solved, feature, plane.normal, axes, holds);
  }
  return holds;
}

// What a prior tells of one direction of a LiDAR's place or turn, 1 / m^2 or 1 / rad^2.
double told_along(const std::vector<std::optional<PosePrior>>& priors, std::size_t lidar, Half half,
                  const Vector3d& axis) {
  if (lidar >= priors.size() || !priors[lidar]) return 0.0;
  Matrix6d C = inverse6(priors[lidar]->information);
  return 1.0 / axis.dot(half_of(C, half) * axis);
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
    axes[i] = symmetric_eigen(C).vectors.col(2 - rank);
  }
  const std::vector<Hold> holds = holds_along(solved, half, axes);
  for (std::size_t i = 0; i < open.size(); ++i) {
    open[i] = open[i] && !(holds[i].facing >= least_share * holds[i].all && holds[i].all > 0.0);
    if (!open[i]) continue;
    const double by_match = told_along(held.lidar_matches, i, half, axes[i]);
    const double by_guess = told_along(held.lidar_priors, i, half, axes[i]);
    for (Eigen::MatrixXd* covariance : {&full.with_priors, &full.data_only}) {
      auto part = half_of(*covariance, half, solved.layout.lidar_index(static_cast<int>(i)));
      const double variance = axes[i].dot(part * axes[i]);
      const double by_others = covariance == &full.with_priors ? by_match + by_guess : by_match;
      const double share = holds[i].all > 0.0 ? holds[i].facing / holds[i].all : 0.0;
      const double by_planes = std::max(0.0, 1.0 / variance - by_others) * share;
      const double honest = std::min(1.0 / std::max(by_planes + by_others, 1e-9), widest * widest);
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

// What the ranges may be off by, as far as the planes do not tell it, moves every LiDAR along its view. Each law that
// allows for what was taken out counts as likely as it is, and then by what it would change.
void widen_by_range_errors(const SolvedPlanes& solved, const AdjustOptions& held, double factor, FullCovariances& full,
                           LidarCovariances& out) {
  const RangeErrors errors =
      find_range_errors(solved.features, solved.state, solved.layout, held, solved.corrected.errors, *solved.ranges);
  if (!errors.known) return;
  const Eigen::Index parameters = errors.shift.cols();
  RangeFit mixed;
  mixed.covariance = Eigen::MatrixXd::Zero(parameters, parameters);
  for (const RangeLaw law : all_range_laws) {
    if (!covers(law, solved.corrected.law)) continue;
    const RangeFit& fit = errors.fit(law);
    const double likely = fit.likely / errors.likely_covering(solved.corrected.law);
    mixed.covariance += likely * factor * fit.covariance;
    // Under the law that it was solved by, what is left of a step is no finding.
    if (law != solved.corrected.law) mixed.covariance += likely * fit.step_m * fit.step_m.transpose();
  }
  const bool is_of_white = covers(solved.corrected.law, RangeLaw::by_darkness);
  for (int i = 0; i < solved.layout.lidars(); ++i) {
    const double darkness = is_of_white ? 0.0 : errors.darkness[static_cast<std::size_t>(i)];
    const Eigen::Index black = parameters / 2 + i;
    out.range_sigma_m.push_back({std::sqrt(mixed.variance_at(i, darkness)), std::sqrt(mixed.covariance(black, black))});
  }
  const Eigen::MatrixXd wider = errors.shift * mixed.covariance * errors.shift.transpose();
  full.with_priors += wider;
  full.data_only += wider;
}

// Mean square of the observations' offsets from their planes over their expected variance; `parameters` were fitted.
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

// Where stops contradict each other by more than all that is told so far.
void widen_by_stops(const SolvedPlanes& solved, const Eigen::MatrixXd& inverse_hessian, std::optional<int> base,
                    LidarCovariances& out) {
  const StopMoves moves = stop_moves(solved.features, solved.state, solved.layout, inverse_hessian, base);
  for (std::size_t i = 0; i < out.with_priors.size(); ++i) {
    out.scatter.push_back(stop_scatter(moves.moves[i], moves.stops[i], out.with_priors[i]));
    out.with_priors[i] = widened(out.with_priors[i], out.scatter[i]);
    out.data_only[i] = widened(out.data_only[i], out.scatter[i]);
  }
}

}  // namespace

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
  const Eigen::MatrixXd inverse_hessian = inverse_information(sum.H);
  full.with_priors = factor * inverse_hessian;
  out.observable = observable_lidars(sum.H, full.with_priors, solved.layout, base);
  if (solved.ranges) widen_by_range_errors(solved, held, 0.5 * factor, full, out);
  widen_open_directions(solved, held, full, out);
  out.with_priors = blocks_of(full.with_priors, solved, base);
  out.data_only = blocks_of(full.data_only, solved, base);
  widen_by_stops(solved, inverse_hessian, base, out);
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
  return direction_words(T_base_sensor.R * symmetric_eigen(C).vectors.col(2));
}

double translation_bound(const Matrix6d& covariance) {
  return std::sqrt(chi2_95_3 * largest(covariance.bottomRightCorner<3, 3>()));
}

double rotation_bound(const Matrix6d& covariance) {
  return std::sqrt(chi2_95_3 * largest(covariance.topLeftCorner<3, 3>()));
}

}  // namespace rigcal
