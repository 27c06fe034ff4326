#include "core/start/rig_start.h"

#include <algorithm>
#include <cmath>

#include "core/start/axis_search.h"
#include "core/start/drive.h"
#include "core/start/hand_eye.h"
#include "core/start/multiview.h"
#include "core/start/own_view.h"
#include "core/start/shape_start.h"
#include "core/start/step_search.h"
#include "core/start/turning.h"
#include "core/start/unguessed.h"

namespace rigcal {
namespace {

// Fewer surfels than this, or a smaller share of them matched, are no overlap.
constexpr std::size_t min_surfels = 20;
constexpr double min_score = 0.15;
// A LiDAR with more surfels than this has seen planes of all directions; one with fewer may slide along the road. A rig
// that stood or turned in several places needs fewer.
constexpr std::size_t enough_surfels = 1500;
constexpr std::size_t enough_surfels_of_many_stops = 400;
constexpr int many_stops = 5;
constexpr double min_shape_score = 0.3;
// Of what a LiDAR saw, so much must lie on what it saw from other stops.
constexpr double min_own_score = 0.1;
// Where less of what the base saw lies on what it saw from other stops, it may not have turned about a point.
constexpr double turning_agreement = 0.85;
// By how much more must, to believe so.
constexpr double clear_gain = 0.02;
// Times that a drive is gone through again with what all LiDARs saw.
constexpr int most_drives = 3;
// What they saw lies better on itself then by this, where the poses are others: the same ones agree to a thousandth.
constexpr double drive_gain = 0.003;
// Of what the LiDARs of a table that turned saw, so much lies on what they saw from other stops, unless it did not.
constexpr double table_agreement = 0.94;
// A stop that stands elsewhere by this has moved; so much of the squares of the normals must lie along its way.
constexpr double elsewhere_m = 0.1;
constexpr double told_share = 0.03;
// How far off what is aligned may be: as it was placed; where that is doubtful.
constexpr double near_m = 0.12;
constexpr double far_m = 0.3;
// All surfels are laid on each other until nothing moves by more than this, or so many times.
constexpr double settled_m = 0.03;
constexpr int most_alignments = 20;
// Steps of a table that turns equally by hand; of one whose turns were measured.
constexpr double assumed_step_sigma_rad = to_rad(3.0);
constexpr double measured_step_sigma_rad = to_rad(0.5);

std::vector<PatchSurfels> patches_of(const std::vector<PatchSurfels>& patches, int lidar) {
  std::vector<PatchSurfels> out;
  for (const PatchSurfels& p : patches) {
    if (p.lidar == lidar && !p.surfels.empty()) out.push_back(p);
  }
  std::sort(out.begin(), out.end(), [](const PatchSurfels& a, const PatchSurfels& b) { return a.stop < b.stop; });
  return out;
}

bool gyro_is_complete(const StartInput& input) {
  if (static_cast<int>(input.R_previous_this.size()) != input.stops) return false;
  return std::all_of(input.R_previous_this.begin() + 1, input.R_previous_this.end(),
                     [](const auto& R) { return R.has_value(); });
}

struct Turned {
  std::vector<double> angle;  // by stop
  double step_sigma_rad;
};

// Where nothing is known, a full turn in equal steps.
Turned turned_angles(const StartInput& input) {
  const auto stops = static_cast<std::size_t>(input.stops);
  Turned out{std::vector<double>(stops, 0.0), measured_step_sigma_rad};
  for (std::size_t j = 1; j < stops; ++j) {
    std::optional<double> step;
    if (j < input.turned_rad.size()) step = input.turned_rad[j];
    if (j < input.R_previous_this.size() && input.R_previous_this[j]) step = log_so3(*input.R_previous_this[j]).norm();
    if (!step) out.step_sigma_rad = assumed_step_sigma_rad;
    out.angle[j] = out.angle[j - 1] + step.value_or(2.0 * pi / input.stops);
  }
  return out;
}

std::vector<Matrix3d> rotations_by_gyro(const StartInput& input) {
  std::vector<Matrix3d> R{Matrix3d::Identity()};
  for (std::size_t j = 1; j < static_cast<std::size_t>(input.stops); ++j)
    R.push_back(nearest_rotation(R.back() * *input.R_previous_this[j]));
  return R;
}

void place_stops(const StartInput& input, const std::vector<PatchSurfels>& base_patches, Start& start) {
  const auto stops = static_cast<std::size_t>(input.stops);
  start.state.T_G_base.assign(stops, SE3{});
  start.stop_known.assign(stops, 0);
  for (const PatchSurfels& p : base_patches) start.stop_known[static_cast<std::size_t>(p.stop)] = 1;
  if (!input.trajectory.empty()) {
    // The world is the rig frame at the first stop.
    SE3 T_first;
    for (const auto& T : input.trajectory) {
      if (T) {
        T_first = *T;
        break;
      }
    }
    start.stop_known.assign(stops, 0);
    for (std::size_t j = 0; j < stops; ++j) {
      if (!input.trajectory[j]) continue;
      start.state.T_G_base[j] = T_first.inverse() * *input.trajectory[j];
      start.stop_known[j] = 1;
    }
    start.given_T_G_base = start.state.T_G_base;
  } else if (stops > 1 && gyro_is_complete(input)) {
    start.state.T_G_base = poses_from_rotations(base_patches, rotations_by_gyro(input));
  } else if (stops > 1 && !input.axis) {
    const Turned turned = turned_angles(input);
    AxisSearchOptions options;
    options.step_sigma_rad = turned.step_sigma_rad;
    const std::vector<OwnTurn> own = find_own_turns(base_patches, turned.angle, options);
    if (!own.empty() && own.front().score >= min_own_score) {
      start.state.T_G_base = own.front().T_zero_this;
    } else {
      // Nothing holds the stops together; the first that is known stays alone.
      const auto first = std::find(start.stop_known.begin(), start.stop_known.end(), 1);
      if (first != start.stop_known.end()) std::fill(first + 1, start.stop_known.end(), 0);
    }
  } else if (stops > 1) {
    std::vector<double> scores;
    // The search is sure of the rotations only: a poor view slides by metres. That the rig turned about a point holds
    // it.
    const std::vector<Matrix3d> R =
        rotations_from_search(base_patches, input.stops, *input.axis, input.R_previous_this, scores);
    start.state.T_G_base = poses_from_rotations(base_patches, R);
    for (std::size_t j = 0; j < stops; ++j) {
      if (scores[j] < min_score) start.stop_known[j] = 0;
    }
  }
}

// The base's own surfels laid on each other; the poses so far hold what the scene leaves open.
void refine_stops(const StartInput& input, const std::vector<PatchSurfels>& base_patches, Start& start) {
  ParameterLayout layout(input.stops, input.lidars);
  MultiviewOptions options;
  options.priors.stop_priors.resize(static_cast<std::size_t>(input.stops));
  for (const PatchSurfels& p : base_patches) {
    if (p.stop == base_patches.front().stop) continue;
    layout.free_stop(p.stop);
    const auto j = static_cast<std::size_t>(p.stop);
    options.priors.stop_priors[j] = isotropic_prior(start.state.T_G_base[j], to_rad(1.0), 0.1);
  }
  align_surfels(base_patches, layout, options, start.state);
}

// Where the turns by the gyro do not lay what the base saw on itself: it may have turned about another axis (a gyro on
// another sensor, whose guess is off), or have been driven.
void try_other_ways(const StartInput& input, const std::vector<PatchSurfels>& base_patches, Start& start) {
  if (!input.trajectory.empty() || input.stops < 2 || !gyro_is_complete(input)) return;
  double best = balanced_agreement(base_patches, start.state.T_G_base);
  const auto try_poses = [&](const std::vector<SE3>& T_G_base) {
    Start other = start;
    other.state.T_G_base = T_G_base;
    refine_stops(input, base_patches, other);
    const double score = balanced_agreement(base_patches, other.state.T_G_base);
    if (score <= best + clear_gain) return;
    best = score;
    start.state.T_G_base = other.state.T_G_base;
  };
  if (best < turning_agreement) {
    AxisSearchOptions options;
    options.step_sigma_rad = measured_step_sigma_rad;
    const std::vector<OwnTurn> own = find_own_turns(base_patches, turned_angles(input).angle, options);
    if (!own.empty()) try_poses(own.front().T_zero_this);
  }
  if (best < turning_agreement) try_poses(poses_of_drive(base_patches, rotations_by_gyro(input)));
}

RegistrationResult place_lidar(const StartInput& input, const std::vector<PatchSurfels>& patches, int lidar,
                               const SurfelIndex& coarse, const SurfelIndex& fine, const std::optional<Vector3d>& axis,
                               const Start& start) {
  MovingSurfels moving{start.state.T_G_base, {}};
  for (const PatchSurfels& p : patches) {
    if (p.lidar != lidar || !start.stop_known[static_cast<std::size_t>(p.stop)]) continue;
    for (const Surfel& s : p.surfels) moving.items.push_back({p.stop, s.mean, s.normal});
  }
  if (moving.items.size() < min_surfels) return {};
  const SE3 guess = *input.guess_T_base_sensor[static_cast<std::size_t>(lidar)];
  const RegistrationResult near = register_surfels(coarse, fine, moving, {guess}, RegistrationOptions{});
  // A table top is easily taken for the floor, and the search does not reach from one to the other.
  if (!axis) return near;
  const std::vector<SE3> heights = mountings_on_map(fine, moving, {{near.X, near.score}}, *axis);
  return nearer_to_guess(near, refine_candidates(coarse, fine, moving, heights));
}

// What the rig turned about, base frame; nothing where it hardly turned.
std::optional<Vector3d> axis_of(const Start& start) {
  if (!turn_of_poses(start.state.T_G_base, start.stop_known)) return std::nullopt;
  return main_axis(poses_from_first(start));
}

std::size_t surfels_of(const std::vector<PatchSurfels>& patches, int lidar) {
  std::size_t count = 0;
  for (const PatchSurfels& p : patches) count += p.lidar == lidar ? p.surfels.size() : 0;
  return count;
}

// LiDARs with few surfels by the shapes of all that they saw.
void place_by_shapes(const StartInput& input, const std::vector<PatchSurfels>& patches, Start& start) {
  if (input.cells == nullptr) return;
  const std::vector<PatchCells>& cells = *input.cells;
  const std::size_t enough = input.stops >= many_stops ? enough_surfels_of_many_stops : enough_surfels;
  std::optional<ShapeMap> map;
  for (int i = 0; i < input.lidars; ++i) {
    const auto si = static_cast<std::size_t>(i);
    if (i == input.base || !input.guess_T_base_sensor[si] || surfels_of(patches, i) >= enough) continue;
    if (!map) map.emplace(cells, input.base, start.state.T_G_base, start.stop_known);
    std::vector<SE3> candidates = search_grid(*input.guess_T_base_sensor[si], RegistrationOptions{});
    if (start.lidar_known[si]) candidates.push_back(start.matches[si].X);
    const ShapeMatch match = map->place(cells, i, candidates);
    // What slid far out of the searched region lies there by chance, and what fits elsewhere as well is no evidence.
    const SE3 move = input.guess_T_base_sensor[si]->inverse() * match.X;
    if (match.score < min_shape_score || move.t.norm() > 1.0 || log_so3(move.R).norm() > 0.6) continue;
    if (start.lidar_known[si] && match.runner_up_score > 0.9 * match.score) continue;
    start.lidar_known[si] = 1;
    start.state.T_base_sensor[si] = match.X;
    start.matches[si] = {match.X, match.score, match.runner_up_score, match.runner_up};
    start.shape_matches[si] = match;
  }
}

void set_alignment_priors(const StartInput& input, const Start& start, AdjustOptions& priors) {
  priors.lidar_priors.assign(static_cast<std::size_t>(input.lidars), {});
  priors.stop_priors.assign(static_cast<std::size_t>(input.stops), {});
  for (int j = 0; j < input.stops; ++j) {
    const auto sj = static_cast<std::size_t>(j);
    priors.stop_priors[sj] = isotropic_prior(start.state.T_G_base[sj], to_rad(1.0), 0.1);
  }
  for (int i = 0; i < input.lidars; ++i) {
    const auto si = static_cast<std::size_t>(i);
    if (i == input.base || !start.lidar_known[si]) continue;
    priors.lidar_priors[si] = isotropic_prior(start.state.T_base_sensor[si], to_rad(3.0), 0.3);
    if (start.shape_matches[si]) priors.lidar_priors[si] = prior_of(*start.shape_matches[si]);
  }
}

// Of any pose, a turn at three metres.
double largest_move(const RigState& before, const RigState& after) {
  constexpr double arm_m = 3.0;
  double most = 0.0;
  const auto measure = [&](const std::vector<SE3>& a, const std::vector<SE3>& b) {
    for (std::size_t k = 0; k < a.size(); ++k)
      most = std::max(most, (a[k].t - b[k].t).norm() + arm_m * rotation_distance(a[k].R, b[k].R));
  };
  measure(before.T_G_base, after.T_G_base);
  measure(before.T_base_sensor, after.T_base_sensor);
  return most;
}

void align_all(const StartInput& input, const std::vector<PatchSurfels>& patches, double from_m, Start& start) {
  ParameterLayout layout(input.stops, input.lidars);
  std::vector<PatchSurfels> used;
  int first = -1;
  for (const PatchSurfels& p : patches) {
    if (start.lidar_known[static_cast<std::size_t>(p.lidar)] && start.stop_known[static_cast<std::size_t>(p.stop)])
      used.push_back(p);
  }
  for (int j = 0; j < input.stops; ++j) {
    const bool seen = std::any_of(used.begin(), used.end(), [&](const PatchSurfels& p) { return p.stop == j; });
    if (!seen) continue;
    if (first < 0)
      first = j;
    else
      layout.free_stop(j);
  }
  for (int i = 0; i < input.lidars; ++i) {
    if (i != input.base && start.lidar_known[static_cast<std::size_t>(i)]) layout.free_lidar(i);
  }
  MultiviewOptions options;
  options.from_m = from_m;
  options.to_m = 0.05;
  // What holds a stop or a LiDAR holds it where it stands: a turn that closes only with what the others saw, or a chain
  // of stops that drifted, comes right in steps. Poses that were given are left no further than once.
  const int most = input.trajectory.empty() ? most_alignments : 1;
  for (int k = 0; k < most; ++k) {
    const RigState before = start.state;
    set_alignment_priors(input, start, options.priors);
    align_surfels(used, layout, options, start.state);
    const double moved_m = largest_move(before, start.state);
    if (moved_m < settled_m) break;
    options.from_m = std::clamp(moved_m, near_m, far_m);
  }
}

// All LiDARs, by their guesses or without, and then everything laid on each other. False when it was stopped.
bool place_lidars(const StartInput& input, const std::vector<PatchSurfels>& patches,
                  const std::vector<PatchSurfels>& base_patches, const RunContext& context, Start& start) {
  const auto lidars = static_cast<std::size_t>(input.lidars);
  start.matches.assign(lidars, {});
  start.shape_matches.assign(lidars, {});
  start.lidar_known.assign(lidars, 0);
  start.lidar_known[static_cast<std::size_t>(input.base)] = 1;
  start.state.T_base_sensor.assign(lidars, SE3{});
  for (std::size_t i = 0; i < lidars; ++i) {
    if (input.guess_T_base_sensor[i]) start.state.T_base_sensor[i] = *input.guess_T_base_sensor[i];
  }
  std::vector<PlacedSurfel> map;
  for (const PatchSurfels& p : base_patches) {
    const SE3& T = start.state.T_G_base[static_cast<std::size_t>(p.stop)];
    for (const Surfel& s : p.surfels) map.push_back({T * s.mean, T.R * s.normal, p.stop});
  }
  if (map.size() < min_surfels) {
    // Without the base there is nothing to search on: the guesses stand, the others' overlap decides.
    for (std::size_t i = 0; i < lidars; ++i) start.lidar_known[i] = input.guess_T_base_sensor[i].has_value();
    align_all(input, patches, near_m, start);
    return true;
  }
  const SurfelIndex coarse(without_repetitions(map, 1.0), 1.0);
  const SurfelIndex fine(without_repetitions(map, 0.25), 0.5);
  const std::optional<Vector3d> axis = axis_of(start);
  for (int i = 0; i < input.lidars; ++i) {
    const auto si = static_cast<std::size_t>(i);
    if (i == input.base || !input.guess_T_base_sensor[si]) continue;
    context.reporter.progress("start: extrinsics", static_cast<double>(i) / input.lidars);
    start.matches[si] = place_lidar(input, patches, i, coarse, fine, axis, start);
    if (start.matches[si].score < min_score) continue;
    start.lidar_known[si] = 1;
    start.state.T_base_sensor[si] = start.matches[si].X;
    if (context.cancelled()) return false;
  }
  const Doubts doubts = place_without_guess(input, patches, start);
  place_by_shapes(input, patches, start);
  reconsider(
      doubts, patches, [&](Start& placed) { align_all(input, patches, far_m, placed); }, start);
  align_all(input, patches, near_m, start);
  return true;
}

bool drove(const Start& start) {
  const std::optional<TurnOfPoses> turn = turn_of_poses(start.state.T_G_base, start.stop_known);
  return turn && turn->drove();
}

// The surfels of all LiDARs that are known as if the base had seen them, a patch a stop.
std::vector<PatchSurfels> seen_by_rig(const StartInput& input, const std::vector<PatchSurfels>& patches,
                                      const Start& start) {
  std::vector<PatchSurfels> out(static_cast<std::size_t>(input.stops));
  for (const PatchSurfels& p : patches) {
    const auto i = static_cast<std::size_t>(p.lidar);
    if (!start.lidar_known[i] || !start.stop_known[static_cast<std::size_t>(p.stop)]) continue;
    const SE3& T = start.state.T_base_sensor[i];
    for (Surfel s : p.surfels) {
      s.mean = T * s.mean;
      s.normal = T.R * s.normal;
      out[static_cast<std::size_t>(p.stop)].surfels.push_back(s);
    }
  }
  for (int j = 0; j < input.stops; ++j) {
    out[static_cast<std::size_t>(j)].lidar = input.base;
    out[static_cast<std::size_t>(j)].stop = j;
  }
  std::erase_if(out, [](const PatchSurfels& p) { return p.surfels.empty(); });
  return out;
}

// Whether surfaces tell of most of the stops that they stand there and not where they were thought to. Along a corridor
// nothing does, and any places fit.
bool are_told(const std::vector<PatchSurfels>& rig, const std::vector<SE3>& before, const std::vector<SE3>& after) {
  std::size_t moved = 0;
  std::size_t told = 0;
  for (const PatchSurfels& p : rig) {
    const auto j = static_cast<std::size_t>(p.stop);
    const Vector3d way = after[j].t - before[j].t;
    if (way.norm() < elsewhere_m) continue;
    double facing = 0.0;
    for (const Surfel& s : p.surfels) facing += std::pow((after[j].R * s.normal).dot(way.normalized()), 2);
    ++moved;
    if (facing >= told_share * static_cast<double>(p.surfels.size())) ++told;
  }
  return told > 0 && 2 * told >= moved;
}

// What one LiDAR saw from a stop may slide along a wall of what it saw before, and all later stops with it; it may even
// have been taken for a turn in place. Together the LiDARs see more sides: where laying all that they saw on itself
// gives other poses that fit it better, these are taken. True then.
bool drive_with_all(const StartInput& input, const std::vector<PatchSurfels>& patches, Start& start) {
  const std::vector<PatchSurfels> rig = seen_by_rig(input, patches, start);
  const double before = balanced_agreement(rig, start.state.T_G_base);
  if (!drove(start) && before >= table_agreement) return false;
  std::vector<Matrix3d> R_G_base;
  for (const SE3& T : start.state.T_G_base) R_G_base.push_back(T.R);
  Start other = start;
  other.state.T_G_base = poses_of_drive(rig, R_G_base);
  refine_stops(input, rig, other);
  const double after = balanced_agreement(rig, other.state.T_G_base);
  if (after <= before + drive_gain || !are_told(rig, start.state.T_G_base, other.state.T_G_base)) return false;
  start.state.T_G_base = other.state.T_G_base;
  return true;
}

}  // namespace

std::vector<SE3> poses_from_first(const Start& start) {
  const auto first = static_cast<std::size_t>(std::find(start.stop_known.begin(), start.stop_known.end(), 1) -
                                              start.stop_known.begin());
  const SE3 T_first_G = start.state.T_G_base[first].inverse();
  std::vector<SE3> out;
  for (const SE3& T : start.state.T_G_base) out.push_back(T_first_G * T);
  return out;
}

Expected<Start> find_start(const StartInput& input, const std::vector<PatchSurfels>& all_patches,
                           const RunContext& context) {
  // A start needs centimetres.
  const std::vector<PatchSurfels> patches = thinned(all_patches, 24000, 300);
  Start start;
  const auto lidars = static_cast<std::size_t>(input.lidars);
  start.state.T_base_sensor.assign(lidars, SE3{});
  std::vector<PatchSurfels> base_patches = patches_of(patches, input.base);
  context.reporter.progress("start: poses", -1.0);
  place_stops(input, base_patches, start);
  std::erase_if(base_patches,
                [&](const PatchSurfels& p) { return !start.stop_known[static_cast<std::size_t>(p.stop)]; });
  if (base_patches.size() > 1) {
    refine_stops(input, base_patches, start);
    try_other_ways(input, base_patches, start);
  }
  if (context.cancelled()) return Error{ErrorKind::cancelled, "stopped", {}, {}};

  if (!place_lidars(input, patches, base_patches, context, start))
    return Error{ErrorKind::cancelled, "stopped", {}, {}};
  if (input.trajectory.empty()) {
    for (int round = 0; round < most_drives && drive_with_all(input, patches, start); ++round) {
      if (!place_lidars(input, patches, base_patches, context, start))
        return Error{ErrorKind::cancelled, "stopped", {}, {}};
    }
  }
  return start;
}

}  // namespace rigcal
