#include "core/start/rig_start.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "core/start/align_all.h"
#include "core/start/axis_search.h"
#include "core/start/hand_eye.h"
#include "core/start/overlap_limits.h"
#include "core/start/own_view.h"
#include "core/start/rig_drive.h"
#include "core/start/shape_start.h"
#include "core/start/stop_poses.h"
#include "core/start/unguessed.h"

namespace rigcal {
namespace {

// A LiDAR with more surfels than this has seen planes of all directions; one with fewer may slide along the road. A rig
// that stood or turned in several places needs fewer.
constexpr std::size_t enough_surfels = 1500;
constexpr std::size_t enough_surfels_of_many_stops = 400;
constexpr int many_stops = 5;
constexpr double min_shape_score = 0.3;
// Times that a drive is gone through again with what all LiDARs saw.
constexpr int most_drives = 3;
// How far off what is aligned may be: as it was placed; where that is doubtful.
constexpr double near_m = 0.12;
constexpr double far_m = 0.3;
// What is right settles in a few alignments; what is wrong wanders on, and is not worth more of them.
constexpr int most_alignments = 20;
constexpr int most_of_doubtful = 8;
// So many surfels, and so many of each patch, tell which of several places is right.
constexpr std::size_t doubtful_items = 6000;
constexpr std::size_t least_of_doubtful_patch = 75;
// Stops that walked farther than this from where a table's turns had placed them may have slid; held firmly they walk
// no farther than this where the rig did turn about a point, and lose no more than this of what fits.
constexpr double slid_m = 0.2;
constexpr double walk_m = 0.1;
constexpr double most_lost = 0.03;
// Of what the LiDARs of a table saw, so much lies on what they saw from other stops, even of few stops; and so much
// more of it where stops are placed rightly instead of wrongly.
constexpr double doubtful_fit = 0.8;
// And so much where all steps were taken for equal from the start: of eight stops right ones are above 0.88, of six
// they may be between the two, as a room is that ended 1.3 degrees off.
constexpr double sure_fit = 0.85;
constexpr double clear_gain = 0.05;
// What is told of an axis is right to this, as the search for steps about it has it.
constexpr double told_axis_rad = to_rad(3.0);
// Of the steps that were assumed, so much the rig must have turned.
constexpr double least_of_assumed = 0.25;
// Of the stops of a table, so many must hang together.
constexpr double least_found = 0.4;

std::vector<PatchSurfels> patches_of(const std::vector<PatchSurfels>& patches, int lidar) {
  std::vector<PatchSurfels> out;
  for (const PatchSurfels& p : patches) {
    if (p.lidar == lidar && !p.surfels.empty()) out.push_back(p);
  }
  std::sort(out.begin(), out.end(), [](const PatchSurfels& a, const PatchSurfels& b) { return a.stop < b.stop; });
  return out;
}

double share_of(const std::vector<PatchSurfels>& some, const std::vector<PatchSurfels>& all) {
  return all.empty() ? 0.0 : static_cast<double>(some.size()) / static_cast<double>(all.size());
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
  const RegistrationResult near = register_surfels(coarse, fine, moving, guess);
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
    std::vector<SE3> candidates = search_grid(*input.guess_T_base_sensor[si]);
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

// What is placed doubtfully is thought over, which takes most of the time.
enum class Doubtful { reconsidered, left };

// All LiDARs, by their guesses or without, and then everything laid on each other. False when it was stopped.
bool place_lidars(const StartInput& input, const std::vector<PatchSurfels>& patches,
                  const std::vector<PatchSurfels>& base_patches, const StopHold& hold, const RunContext& context,
                  Start& start, Doubtful doubtful = Doubtful::reconsidered) {
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
    align_all(input, patches, near_m, hold, most_alignments, start);
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
  if (doubtful == Doubtful::reconsidered) {
    const std::vector<PatchSurfels> few = thinned(patches, doubtful_items, least_of_doubtful_patch);
    reconsider(
        doubts, patches, [&](Start& placed) { align_all(input, few, far_m, hold, most_of_doubtful, placed); }, start);
  }
  align_all(input, patches, near_m, hold, most_alignments, start);
  return true;
}

// The farthest of the stops that are known.
double farthest(const Start& start, const Start& from) {
  double most = 0.0;
  for (std::size_t j = 0; j < start.stop_known.size(); ++j) {
    if (start.stop_known[j]) most = std::max(most, (start.state.T_G_base[j].t - from.state.T_G_base[j].t).norm());
  }
  return most;
}

// How well what all LiDARs saw lies on itself.
double fit_of(const StartInput& input, const std::vector<PatchSurfels>& patches, const Start& start) {
  return balanced_agreement(seen_by_rig(input, patches, start), start.state.T_G_base);
}

// What turned before walls slides along them, stop by stop, by what a few surfels have wrong, and the gaps that open
// are not seen. Where the rig turned about a point everything is found as well with the stops held there: that start.
// `turned`: the stops as the turns placed them. Nothing also when it was stopped.
std::optional<Start> held_where_it_turned(const StartInput& input, const std::vector<PatchSurfels>& patches,
                                          const std::vector<PatchSurfels>& base_patches, const Start& turned,
                                          const RunContext& context, const Start& start) {
  if (farthest(start, turned) < slid_m) return std::nullopt;
  Start held = turned;
  refine_stops(input, base_patches, firm_hold, held);
  if (farthest(held, turned) > walk_m) return std::nullopt;
  if (!place_lidars(input, patches, base_patches, firm_hold, context, held)) return std::nullopt;
  if (farthest(held, turned) > walk_m) return std::nullopt;
  if (fit_of(input, patches, held) < fit_of(input, patches, start) - most_lost) return std::nullopt;
  return held;
}

Start nothing_placed(const StartInput& input) {
  Start start;
  start.state.T_base_sensor.assign(static_cast<std::size_t>(input.lidars), SE3{});
  return start;
}

// From where the stops stand to where everything does. Nothing when it was stopped.
std::optional<Start> from_stops(const StartInput& input, const std::vector<PatchSurfels>& patches,
                                std::vector<PatchSurfels> base_patches, const RunContext& context, Start start) {
  base_patches = known_of(std::move(base_patches), start);
  const Start turned = start;
  if (base_patches.size() > 1) {
    refine_stops(input, base_patches, loose_hold, start);
    try_other_ways(input, base_patches, start);
  }
  if (context.cancelled()) return std::nullopt;
  if (!place_lidars(input, patches, base_patches, loose_hold, context, start)) return std::nullopt;
  if (!input.trajectory.empty()) return start;
  const std::optional<Start> held = held_where_it_turned(input, patches, base_patches, turned, context, start);
  if (context.cancelled()) return std::nullopt;
  if (held) return held;
  for (int round = 0; round < most_drives && drive_with_all(input, patches, start); ++round) {
    if (!place_lidars(input, patches, base_patches, loose_hold, context, start)) return std::nullopt;
  }
  return start;
}

struct Attempt {
  Start start;
  double fit = 0.0;
};

// From where `place` puts the stops, but for what is doubtful. Nothing where too few of them are known, or it was
// stopped.
std::optional<Attempt> attempt(const StartInput& input, const std::vector<PatchSurfels>& patches,
                               const std::vector<PatchSurfels>& base_patches, const RunContext& context,
                               const std::function<void(Start&)>& place) {
  Attempt out{nothing_placed(input)};
  place(out.start);
  const std::vector<PatchSurfels> known = known_of(base_patches, out.start);
  if (share_of(known, base_patches) < least_found) return std::nullopt;
  refine_stops(input, known, loose_hold, out.start);
  if (!place_lidars(input, patches, known, loose_hold, context, out.start, Doubtful::left)) return std::nullopt;
  out.fit = fit_of(input, patches, out.start);
  return out;
}

// A LiDAR that leans is easily forgotten where the axis is told in its frame. Equal steps about any other axis are
// believed where nearly all lies on itself then, which it does not about the one that was told. False: there is none.
bool try_other_axis(const StartInput& input, const std::vector<PatchSurfels>& patches,
                    const std::vector<PatchSurfels>& base_patches, const RunContext& context, double fit,
                    Start& start) {
  StartInput any = input;
  any.axis.reset();
  std::optional<Attempt> other =
      attempt(any, patches, base_patches, context, [&](Start& placed) { place_stops(any, base_patches, placed); });
  if (!other || other->fit < std::max(sure_fit, fit + clear_gain)) return false;
  std::optional<Vector3d> axis = axis_of(other->start);
  if (!axis) return false;
  if (axis->dot(*input.axis) < 0.0) *axis = -*axis;
  if (axis->dot(input.axis->normalized()) > std::cos(told_axis_rad)) return false;
  start = std::move(other->start);
  start.other_axis = axis;
  return true;
}

// What the base sees from one stop it may not see from the next, and is lost then or laid on something else. Where
// little of what was seen lies on itself, the table may have turned all round in equal steps, this way or that, which
// is told as what it rests on; or by steps that need not be equal, even if some stops are not known then. What fits
// clearly better is taken.
void try_other_steps(const StartInput& input, const std::vector<PatchSurfels>& patches,
                     const std::vector<PatchSurfels>& base_patches, const RunContext& context, Start& start) {
  double fit = fit_of(input, patches, start);
  if (fit * share_of(known_of(base_patches, start), base_patches) >= doubtful_fit) return;
  if (!input.goes_on && try_other_axis(input, patches, base_patches, context, fit, start)) {
    place_lidars(input, patches, known_of(base_patches, start), loose_hold, context, start);
    return;
  }
  const auto try_steps = [&](const std::function<void(Start&)>& place) {
    return attempt(input, patches, base_patches, context, place);
  };
  bool is_other = false;
  const auto take_if_better = [&](std::optional<Attempt> other) {
    if (!other || other->fit < fit + clear_gain) return;
    fit = other->fit;
    start = std::move(other->start);
    is_other = true;
  };
  if (!input.goes_on && fit < doubtful_fit) {
    std::optional<Attempt> equal;
    for (const double way : {1.0, -1.0}) {
      std::optional<Attempt> other = try_steps([&](Start& placed) {
        place_in_equal_steps(input, base_patches, way, placed);
        placed.has_assumed_steps = turns_in_assumed_steps(input);
      });
      if (other && (!equal || other->fit > equal->fit)) equal = std::move(other);
    }
    take_if_better(std::move(equal));
  }
  take_if_better(try_steps([&](Start& placed) { place_by_evidence(input, base_patches, placed); }));
  // What is doubtful there may still be right elsewhere.
  if (is_other) place_lidars(input, patches, known_of(base_patches, start), loose_hold, context, start);
}

// What was seen from one place lies on itself, too, and says nothing of LiDARs that look apart.
bool turned_as_assumed(const Start& start) {
  const double assumed_rad = 2.0 * pi / static_cast<double>(start.stop_known.size());
  return usual_step(start.state.T_G_base, start.stop_known).turn_rad >= least_of_assumed * assumed_rad;
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
  Start placed = nothing_placed(input);
  const std::vector<PatchSurfels> base_patches = patches_of(patches, input.base);
  context.reporter.progress("start: poses", -1.0);
  place_stops(input, base_patches, placed);
  std::optional<Start> start = from_stops(input, patches, base_patches, context, placed);
  if (start && has_unknown_steps(input)) try_other_steps(input, patches, base_patches, context, *start);
  if (!start || context.cancelled()) return cancelled_error();
  // Without an axis, steps that nothing told were taken for equal ones from the start: right where all lies on itself.
  if (!input.axis && turns_in_assumed_steps(input)) {
    start->has_assumed_steps = fit_of(input, patches, *start) < sure_fit || !turned_as_assumed(*start);
  }
  return *std::move(start);
}

}  // namespace rigcal
