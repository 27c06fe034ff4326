#include "core/start/axis_search.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/best_apart.h"
#include "core/base/parallel.h"
#include "core/geometry/spiral_direction.h"
#include "core/geometry/symmetric_solve.h"
#include "core/start/multiview.h"
#include "core/start/own_view.h"

namespace rigcal {
namespace {

constexpr double wander_rad = to_rad(1.0);  // By how much a stop that wanders may be tilted.

constexpr std::size_t directions = 1200;  // some six degrees apart
constexpr std::size_t searched_items = 1000;
// All directions are tried with every so many-th of them, the best with all.
constexpr std::size_t first_stride = 4;
constexpr std::size_t searched_directions = 200;
constexpr std::size_t first_items = 800;
constexpr std::size_t solved_items = 2000;
constexpr std::size_t least_of_patch = 20;
constexpr std::size_t finalists = 3;
constexpr std::size_t min_items = 40;
constexpr std::size_t peaks = 5;
constexpr double peak_apart_rad = to_rad(15.0);
// Turns that fit at least this well, compared with the best, are told; the same ones only once.
constexpr double contender_share = 0.75;
constexpr double same_axis_rad = to_rad(5.0);
constexpr double same_foot_m = 0.3;
// What fits only about an axis far away (floors and long walls do, turned the other way round) is no table.
constexpr double max_foot_m = 3.0;
constexpr double residual_m = 0.02;  // spread of surfels of one surface
constexpr double damping = 1e-6;

struct Axis {
  Vector3d direction;
  double score = 0.0;
};

// Where neighbouring stops agree best when the foot is taken for the sensor itself.
std::vector<Axis> axis_peaks(const std::vector<PatchSurfels>& patches, const std::vector<double>& angle) {
  const std::vector<PatchSurfels> few = thinned(patches, searched_items, least_of_patch);
  std::vector<SurfelIndex> before;
  for (std::size_t k = 0; k + 1 < patches.size(); ++k) before.push_back(index_of(patches[k], 1.0));
  const double cosine = std::cos(to_rad(26.0));
  const auto score = [&](const Vector3d& axis, std::size_t stride) {
    std::size_t matched = 0;
    for (std::size_t k = 0; k + 1 < patches.size(); ++k) {
      const double step =
          angle[static_cast<std::size_t>(patches[k + 1].stop)] - angle[static_cast<std::size_t>(patches[k].stop)];
      const Matrix3d R = exp_so3(step * axis);
      const std::vector<Surfel>& surfels = few[k + 1].surfels;
      for (std::size_t i = 0; i < surfels.size(); i += stride)
        matched += before[k].contains(R * surfels[i].mean, R * surfels[i].normal, cosine, 0.35) ? 1 : 0;
    }
    return static_cast<double>(matched);
  };
  std::vector<Axis> all(directions);
  for (std::size_t i = 0; i < directions; ++i) all[i].direction = spiral_direction(i, directions);
  for (const std::size_t stride : {first_stride, std::size_t{1}}) {
    parallel_for(all.size(), 32, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) all[i].score = score(all[i].direction, stride);
    });
    std::stable_sort(all.begin(), all.end(), [](const Axis& a, const Axis& b) { return a.score > b.score; });
    all.resize(searched_directions);
  }
  return best_apart(std::move(all), peaks, [](const Axis& a, const Axis& b) {
    return a.direction.dot(b.direction) > std::cos(peak_apart_rad);
  });
}

// Gauss-Newton on axis, foot and the angles of all stops but the first.
class TurnSolver {
 public:
  /// `given` and `start`, where it begins, by stop.
  TurnSolver(const std::vector<PatchSurfels>& patches, const std::vector<double>& given, double step_sigma_rad,
             const std::vector<double>& start)
      : patches_(patches), step_weight_(1.0 / (step_sigma_rad * step_sigma_rad)) {
    for (const PatchSurfels& p : patches) {
      const auto j = static_cast<std::size_t>(p.stop);
      given_.push_back(given[j]);
      angles_.push_back(start[j]);
    }
  }

  [[nodiscard]] const std::vector<double>& angles() const { return angles_; }

  // Surfels of patches at most `span` apart are laid on each other.
  void step(double tolerance, int span, Vector3d& axis, Vector3d& foot) {
    std::vector<PlacedSurfel> placed;
    std::vector<Vector3d> arms;
    for (std::size_t k = 0; k < patches_.size(); ++k) {
      const Matrix3d R = exp_so3(angles_[k] * axis);
      for (const Surfel& s : patches_[k].surfels) {
        arms.push_back(s.mean - foot);
        placed.push_back({R * arms.back() + foot, R * s.normal, static_cast<int>(k)});
      }
    }
    const SurfelIndex index(placed, std::max(0.6, tolerance));
    const auto count = static_cast<Eigen::Index>(6 + patches_.size());
    Eigen::MatrixXd H = Eigen::MatrixXd::Zero(count, count);
    Eigen::VectorXd g = Eigen::VectorXd::Zero(count);
    const double min_cosine = std::cos(to_rad(std::min(24.0, 10.0 + 24.0 * tolerance)));
    std::vector<int> partners;
    for (std::size_t i = 0; i < placed.size(); ++i) {
      const PlacedSurfel& a = placed[i];
      index.find_all(a.mean, a.normal, min_cosine, tolerance, a.group, 6, partners);
      for (const int partner : partners) {
        const PlacedSurfel& b = placed[static_cast<std::size_t>(partner)];
        if (std::abs(a.group - b.group) > span) continue;
        const double r = b.normal.dot(a.mean - b.mean);
        const double w = 1.0 / (residual_m * residual_m * (1.0 + 4.0 * r * r / (tolerance * tolerance)));
        const Row of_a = row(a, arms[i], b.normal, axis, foot);
        const Row of_b = row(b, arms[static_cast<std::size_t>(partner)], b.normal, axis, foot);
        Eigen::Matrix<double, 8, 1> J;
        J << of_a.turn - of_b.turn, of_a.angle, -of_b.angle;
        const std::array<Eigen::Index, 2> at{6 + a.group, 6 + b.group};
        H.topLeftCorner<6, 6>() += w * J.head<6>() * J.head<6>().transpose();
        g.head<6>() += w * r * J.head<6>();
        for (std::size_t u = 0; u < 2; ++u) {
          const double Ju = J[static_cast<Eigen::Index>(6 + u)];
          H.block<6, 1>(0, at[u]) += w * Ju * J.head<6>();
          g[at[u]] += w * r * Ju;
          for (std::size_t v = 0; v < 2; ++v) H(at[u], at[v]) += w * Ju * J[static_cast<Eigen::Index>(6 + v)];
        }
      }
    }
    for (Eigen::Index k = 6; k < count; ++k) H.block<1, 6>(k, 0) = H.block<6, 1>(0, k).transpose();
    add_step_priors(H, g);
    // Along the axis neither a turn of it nor a shift of its foot means anything.
    const Matrix3d along = axis * axis.transpose();
    H.block<3, 3>(0, 0) += H.diagonal().head<3>().sum() * along;
    H.block<3, 3>(3, 3) += H.diagonal().segment<3>(3).sum() * along;
    H.diagonal().head<3>().array() += damping * H.diagonal().head<3>().mean() + 1e-6;
    H.diagonal().segment<3>(3).array() += damping * H.diagonal().segment<3>(3).mean() + 1e-6;
    H(6, 6) += 1e12;
    const Eigen::VectorXd dx = -solve_symmetric_x(H, g);
    if (!dx.allFinite()) return;
    axis = (exp_so3(dx.head<3>()) * axis).normalized();
    foot += dx.segment<3>(3);
    foot -= foot.dot(axis) * axis;
    for (std::size_t k = 1; k < angles_.size(); ++k) angles_[k] += dx[static_cast<Eigen::Index>(6 + k)];
  }

 private:
  struct Row {
    Vector6d turn;  // by a turn of the axis and a shift of the foot
    double angle;
  };
  [[nodiscard]] Row row(const PlacedSurfel& s, const Vector3d& arm, const Vector3d& normal, const Vector3d& axis,
                        const Vector3d& foot) const {
    const Matrix3d R = exp_so3(angles_[static_cast<std::size_t>(s.group)] * axis);
    const Vector3d turned = s.mean - foot;
    const Vector3d back = R.transpose() * normal;
    Row out;
    out.turn << turned.cross(normal) - arm.cross(back), normal - back;
    out.angle = normal.dot(axis.cross(turned));
    return out;
  }
  void add_step_priors(Eigen::MatrixXd& H, Eigen::VectorXd& g) const {
    for (std::size_t k = 1; k < angles_.size(); ++k) {
      const double off = angles_[k] - angles_[k - 1] - (given_[k] - given_[k - 1]);
      const auto b = static_cast<Eigen::Index>(6 + k);
      const Eigen::Index a = b - 1;
      H(a, a) += step_weight_;
      H(b, b) += step_weight_;
      H(a, b) -= step_weight_;
      H(b, a) -= step_weight_;
      g[a] -= step_weight_ * off;
      g[b] += step_weight_ * off;
    }
  }

  const std::vector<PatchSurfels>& patches_;
  double step_weight_;
  std::vector<double> given_;
  std::vector<double> angles_;
};

std::vector<SE3> poses_of(const AxisTurn& turn) {
  std::vector<SE3> poses;
  for (std::size_t j = 0; j < turn.angle.size(); ++j) poses.push_back(turn.pose(static_cast<int>(j)));
  return poses;
}

// From the angles at the stops with a patch to those at all stops.
AxisTurn turn_of(const std::vector<PatchSurfels>& patches, const TurnSolver& solver, const std::vector<double>& angle,
                 const Vector3d& axis, const Vector3d& foot) {
  AxisTurn turn{axis, foot, angle};
  double moved = 0.0;
  std::size_t next = 0;
  for (std::size_t j = 0; j < angle.size(); ++j) {
    if (next < patches.size() && patches[next].stop == static_cast<int>(j)) {
      moved = solver.angles()[next] - angle[j];
      ++next;
    }
    turn.angle[j] = angle[j] + moved;
  }
  return turn;
}

struct Pass {
  double tolerance;
  int span;
  int repeats;
};

// Carries all contenders through passes of the solver; the best comes first.
void refine_all(const std::vector<PatchSurfels>& patches, const std::vector<double>& angle, double step_sigma_rad,
                const std::vector<Pass>& passes, std::vector<OwnTurn>& contenders) {
  parallel_for(contenders.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      OwnTurn& own = contenders[i];
      TurnSolver solver(patches, angle, step_sigma_rad, own.turn.angle);
      for (const Pass& pass : passes) {
        for (int k = 0; k < pass.repeats; ++k) solver.step(pass.tolerance, pass.span, own.turn.axis, own.turn.foot);
      }
      own.turn = turn_of(patches, solver, angle, own.turn.axis, own.turn.foot);
      own.T_zero_this = poses_of(own.turn);
      own.score = balanced_agreement(patches, own.T_zero_this);
    }
  });
  std::stable_sort(contenders.begin(), contenders.end(),
                   [](const OwnTurn& a, const OwnTurn& b) { return a.score > b.score; });
}

// Each stop free to stand a little off the turn.
void set_free(const std::vector<PatchSurfels>& patches, const AxisSearchOptions& options, OwnTurn& own) {
  std::vector<PatchSurfels> alone = thinned(patches, 2 * solved_items, least_of_patch);
  const auto stops = static_cast<int>(own.T_zero_this.size());
  ParameterLayout layout(stops, 1);
  MultiviewOptions multiview;
  multiview.from_m = std::max(0.12, 2.0 * options.wander_m);
  multiview.priors.stop_priors.resize(own.T_zero_this.size());
  for (PatchSurfels& p : alone) {
    p.lidar = 0;
    if (p.stop == patches.front().stop) continue;
    layout.free_stop(p.stop);
    const auto j = static_cast<std::size_t>(p.stop);
    multiview.priors.stop_priors[j] = isotropic_prior(own.T_zero_this[j], wander_rad, options.wander_m);
  }
  RigState state{own.T_zero_this, {SE3{}}};
  align_surfels(alone, layout, multiview, state);
  own.T_zero_this = state.T_G_base;
  own.score = balanced_agreement(alone, own.T_zero_this);
}

}  // namespace

SE3 AxisTurn::pose(int stop) const {
  const Matrix3d R = exp_so3(angle[static_cast<std::size_t>(stop)] * axis);
  return {R, foot - R * foot};
}

std::optional<TurnOfPoses> turn_of_poses(const std::vector<SE3>& T_G_base, const std::vector<char>& stop_known) {
  std::vector<std::size_t> stops;
  for (std::size_t j = 0; j < T_G_base.size(); ++j) {
    if (stop_known[j]) stops.push_back(j);
  }
  if (stops.size() < 2) return std::nullopt;
  std::vector<Vector3d> steps;
  for (std::size_t k = 1; k < stops.size(); ++k)
    steps.push_back(log_so3(T_G_base[stops[k - 1]].R.transpose() * T_G_base[stops[k]].R));
  const auto longest = std::max_element(steps.begin(), steps.end(), [](const Vector3d& a, const Vector3d& b) {
    return a.squaredNorm() < b.squaredNorm();
  });
  Vector3d sum = Vector3d::Zero();
  for (const Vector3d& s : steps) sum += s.dot(*longest) < 0.0 ? Vector3d(-s) : s;
  if (sum.norm() < to_rad(20.0)) return std::nullopt;
  TurnOfPoses out;
  out.turn.axis = sum.normalized();
  out.turn.angle.assign(T_G_base.size(), 0.0);
  double angle = 0.0;
  for (std::size_t k = 0; k < stops.size(); ++k) {
    if (k > 0) angle += steps[k - 1].dot(out.turn.axis);
    const std::size_t until = k + 1 < stops.size() ? stops[k + 1] : T_G_base.size();
    for (std::size_t j = stops[k]; j < until; ++j) out.turn.angle[j] = angle;
  }
  // (I - R_j) f = t_j - t_first, R_j as the turn has it from the first pose on; the share along the axis is left out.
  const SE3 T_first = T_G_base[stops[0]];
  Matrix3d H = Matrix3d::Zero();
  Vector3d g = Vector3d::Zero();
  for (const std::size_t j : stops) {
    const SE3 T = T_first.inverse() * T_G_base[j];
    const Matrix3d A = Matrix3d::Identity() - T.R;
    H += A.transpose() * A;
    g += A.transpose() * T.t;
  }
  H += (1e-3 * H.trace() + 1e-9) * out.turn.axis * out.turn.axis.transpose();
  H.diagonal().array() += 1e-9;
  out.turn.foot = solve_symmetric3(H, g);
  out.turn.foot -= out.turn.foot.dot(out.turn.axis) * out.turn.axis;
  double square = 0.0;
  const Vector3d side = out.turn.foot + 0.5 * out.turn.axis.unitOrthogonal();
  for (const std::size_t j : stops)
    square += (T_first.inverse() * T_G_base[j] * side - out.turn.pose(static_cast<int>(j)) * side).squaredNorm();
  out.off_m = std::sqrt(square / static_cast<double>(stops.size()));
  return out;
}

std::vector<OwnTurn> find_own_turns(const std::vector<PatchSurfels>& patches, const std::vector<double>& angle,
                                    const AxisSearchOptions& options) {
  std::size_t items = 0;
  for (const PatchSurfels& p : patches) items += p.surfels.size();
  if (patches.size() < 2 || items < min_items) return {};
  std::vector<Axis> starts;
  if (options.axis) {
    starts.push_back({*options.axis});
  } else {
    starts = axis_peaks(patches, angle);
  }
  std::vector<OwnTurn> contenders;
  for (const Axis& start : starts) contenders.push_back({{start.direction, Vector3d::Zero(), angle}, {}, 0.0});
  // First neighbours only, which the unknown foot displaces least; then all pairs, when it is nearly right.
  const double sigma = options.step_sigma_rad;
  refine_all(thinned(patches, first_items, least_of_patch), angle, sigma, {{0.6, 1, 5}, {0.35, 2, 5}}, contenders);
  std::erase_if(contenders, [](const OwnTurn& own) { return own.turn.foot.norm() > max_foot_m; });
  contenders.resize(std::min(finalists, contenders.size()));
  refine_all(thinned(patches, solved_items, least_of_patch), angle, sigma, {{0.25, 1000, 4}, {0.1, 1000, 4}},
             contenders);
  const double least = contenders.empty() ? 0.0 : contender_share * contenders.front().score;
  std::erase_if(contenders, [&](const OwnTurn& own) { return own.score < least || own.turn.foot.norm() > max_foot_m; });
  std::vector<OwnTurn> kept = best_apart(std::move(contenders), finalists, [](const OwnTurn& a, const OwnTurn& b) {
    return a.turn.axis.dot(b.turn.axis) > std::cos(same_axis_rad) && (a.turn.foot - b.turn.foot).norm() < same_foot_m;
  });
  if (options.wander_m == 0.0) return kept;
  parallel_for(kept.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) set_free(patches, options, kept[i]);
  });
  std::stable_sort(kept.begin(), kept.end(), [](const OwnTurn& a, const OwnTurn& b) { return a.score > b.score; });
  return kept;
}

}  // namespace rigcal
