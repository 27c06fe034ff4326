#include "core/pipeline/lidar_calibration.h"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "core/base/text.h"
#include "core/pipeline/frozen_directions.h"
#include "core/pipeline/lidar_result.h"
#include "core/pipeline/range_stage.h"
#include "core/pipeline/result_map.h"
#include "core/pipeline/solution_words.h"
#include "core/pipeline/solving_base.h"
#include "core/pipeline/solving_priors.h"
#include "core/pipeline/stage_clock.h"
#include "core/pipeline/stop_groups.h"
#include "core/pipeline/stop_misfits.h"
#include "core/pipeline/stop_placement.h"
#include "core/pipeline/surface_trust.h"
#include "core/pipeline/turn_misfits.h"
#include "core/start/noise_estimate.h"
#include "core/start/stop_poses.h"
#include "core/start/trajectory_mixup.h"

namespace rigcal {
namespace {

// Bounds only; passes end when nothing moves any more, and only what does not rest is settled.
constexpr int max_tight_passes = 8;
constexpr int max_settling_passes = 8;

// Of an estimate while more stops are to come; they end when nothing moves any more.
constexpr int tight_passes_of_estimate = 5;

// The last map of all moves poses by tenths of a millimetre, over which the cost is a parabola.
constexpr int last_iterations = 2;

// Each takes out most of what the one before left.
constexpr int most_range_rounds = 3;

// What carries through the stages.
class Calibration {
 public:
  Calibration(const Rig& rig, const LidarRecording& recording, const std::vector<std::optional<SE3>>& guess,
              const LidarCalibrationOptions& options, const RunContext& context)
      : rig_(rig),
        recording_(recording),
        guess_(guess),
        options_(options),
        context_(context),
        solving_guess_(guess),
        solution_(stops(), lidars()) {}

  [[nodiscard]] LidarSolution take_solution() { return std::move(solution_); }

  Expected<CalibrationResult> run() {
    if (const auto right = check(); !right) return right.error();
    if (const auto done = find_rough(false); !done) return done.error();
    choose_patches(0);
    if (const auto done = solve(); !done) return done.error();
    if (const auto done = take_out_range_errors(); !done) return done.error();
    if (const auto done = even_out(); !done) return done.error();
    return conclude();
  }

  Expected<CalibrationResult> estimate(const WarmStart* warm) {
    if (const auto right = check(); !right) return right.error();
    if (warm != nullptr) {
      solution_.start = warm->start;
      solution_.state = warm->start.state;
      solution_.noise = warm->noise;
      solution_.T_grid_G = warm->T_grid_G;
      solution_.gyro_lidar = warm->gyro_lidar;
    } else if (const auto done = find_rough(true); !done) {
      return done.error();
    }
    choose_patches(warm != nullptr ? warm->stops_before : 0);
    solution_.adjust = solving_priors(recording_, solution_.start, solving_guess_, options_);
    trust_.distrust_noise();  // errors of ranges are not looked for here
    const std::vector<RefinePass> passes = standard_passes(tight_passes_of_estimate);
    if (const auto done = run_joint({passes.begin() + (warm != nullptr ? 1 : 0), passes.end()}); !done) {
      return done.error();
    }
    clock_.begin("verdict");
    CalibrationResult result = judge();
    result.stages = clock_.take();
    return result;
  }

 private:
  Expected<void> check() {
    const auto base = std::find(recording_.lidar_sensors.begin(), recording_.lidar_sensors.end(), rig_.base);
    if (base == recording_.lidar_sensors.end()) return input_error("the base sensor of the rig is no LiDAR", rig_.name);
    base_ = static_cast<int>(base - recording_.lidar_sensors.begin());
    solving_ = base_;
    if (recording_.stops.empty()) return input_error("there is no stop in which the rig stands still");
    return {};
  }

  [[nodiscard]] int stops() const { return static_cast<int>(recording_.stops.size()); }
  [[nodiscard]] int lidars() const { return static_cast<int>(recording_.lidar_sensors.size()); }
  [[nodiscard]] int sensor_of(int lidar) const { return recording_.lidar_sensors[static_cast<std::size_t>(lidar)]; }

  Expected<void> find_rough(bool goes_on) {
    StageReport& stage = clock_.begin("start");
    std::vector<PatchSurfels> found;
    if (recording_.surfels.empty()) found = extract_surfels(recording_.patches, SurfelOptions{});
    const std::vector<PatchSurfels>& surfels = recording_.surfels.empty() ? found : recording_.surfels;
    std::size_t count = 0;
    for (const PatchSurfels& p : surfels) count += p.surfels.size();
    stage.counts.emplace_back("surfels", static_cast<double>(count));
    for (int i = 0; i < lidars(); ++i) solution_.noise.push_back(estimate_noise(surfels, i, NoiseModel{}));
    StartInput input;
    input.stops = stops();
    input.lidars = lidars();
    input.base = base_;
    input.guess_T_base_sensor = guess_;
    input.R_previous_this = recording_.R_previous_this;
    input.trajectory = recording_.trajectory;
    input.cells = &recording_.patches;
    input.goes_on = goes_on;
    input.turned_rad = with_signs(recording_.turned_rad, recording_.gyro_turns);
    if (rig_.turntable) input.axis = rig_.turntable->axis;
    warn_of_mixups(surfels);
    Expected<Start> start = start_in(solving_lidar(input, recording_.gyro_turns, surfels), input, surfels);
    if (!start) return start.error();
    // What the base shares with others but not with that LiDAR must be found from its own side.
    if (!start->lidar_known[static_cast<std::size_t>(base_)]) start = start_in(base_, input, surfels);
    if (!start) return start.error();
    // What the one LiDAR did not see twice others did.
    if (has_unknown_steps(input)) find_left_out(surfels, *start);
    if (start->other_axis) context_.reporter.warn(other_axis_words(*input.axis, *start->other_axis));
    solution_.start = std::move(*start);
    solution_.state = solution_.start.state;
    solution_.T_grid_G = frame_of(surfels);
    if (options_.on_pass) options_.on_pass("start", solution_.state);
    tell("start");
    return {};
  }

  [[nodiscard]] std::string other_axis_words(const Vector3d& told, const Vector3d& found) const {
    const auto list = [](const Vector3d& d) {
      return "[" + fixed_text(d.x(), 3) + ", " + fixed_text(d.y(), 3) + ", " + fixed_text(d.z(), 3) + "]";
    };
    const double off_rad = std::acos(std::clamp(found.dot(told.normalized()), -1.0, 1.0));
    return "the rig turned about " + list(found) + " of the frame of " + rig_.base_sensor().name + ", " +
           fixed_text(to_deg(off_rad), 0) +
           " degrees from the axis of the turntable in the rig file: that one is used; mend axis in the rig file (it "
           "is told in the frame of the base, however that leans)";
  }

  void warn_of_mixups(const std::vector<PatchSurfels>& surfels) const {
    if (!recording_.trajectory_is_prior) return;
    const TrajectoryMixup mixup = trajectory_mixup(surfels, base_, recording_.trajectory);
    if (mixup != TrajectoryMixup::none) context_.reporter.warn(to_words(mixup));
  }

  Expected<Start> start_in(int lidar, const StartInput& of_base, const std::vector<PatchSurfels>& surfels) {
    solving_ = lidar;
    const StartInput input = seen_from(lidar, of_base, recording_.gyro_turns);
    solving_guess_ = input.guess_T_base_sensor;
    solution_.gyro_lidar = input.turns_are_own ? std::optional(lidar) : std::nullopt;
    return find_start(input, surfels, context_);
  }

  // The grid's frame from everything that was seen, whichever sensor is the base.
  SE3 frame_of(const std::vector<PatchSurfels>& surfels) const {
    std::vector<Vector3d> normals;
    std::vector<Vector3d> centers;
    std::vector<double> weights;
    for (const PatchSurfels& p : surfels) {
      if (!solution_.start.lidar_known[static_cast<std::size_t>(p.lidar)]) continue;
      const SE3 T = solution_.state.T_G_sensor(p.stop, p.lidar);
      for (const Surfel& s : p.surfels) {
        normals.push_back(T.R * s.normal);
        centers.push_back(T * s.mean);
        weights.push_back(s.N);
      }
    }
    return grid_frame(normals, centers, weights);
  }

  // Tells which stops are left out, from `first_told` on.
  void choose_patches(int first_told) {
    solution_.use.assign(recording_.patches.size(), 0);
    for (std::size_t k = 0; k < recording_.patches.size(); ++k) {
      const PatchCells& p = recording_.patches[k];
      solution_.use[k] = solution_.start.lidar_known[static_cast<std::size_t>(p.lidar)] &&
                         solution_.start.stop_known[static_cast<std::size_t>(p.stop)] && !p.cells.empty();
    }
    const std::vector<char> told = told_stops();
    const bool is_told = std::find(told.begin(), told.end(), 1) != told.end() ||
                         std::any_of(recording_.turned_rad.begin(), recording_.turned_rad.end(),
                                     [](const std::optional<double>& turned) { return turned.has_value(); });
    const bool has_axis = rig_.turntable && rig_.turntable->axis;
    const std::string mend = is_told    ? ""
                             : has_axis ? "; without a gyro, turn by smaller steps, and check the table's axis in the "
                                          "rig file (in the frame of the base)"
                                        : "; without a gyro, turn by smaller steps, all equal to 6 degrees, or tell "
                                          "the table's axis in the rig file";
    for (auto j = static_cast<std::size_t>(first_told); j < recording_.stops.size(); ++j) {
      if (solution_.start.stop_known[j]) continue;
      context_.reporter.warn("stop " + std::to_string(recording_.stops[j].index) +
                             " is left out: its pose was not found from the surfaces of " +
                             rig_.sensors[static_cast<std::size_t>(sensor_of(solving_))].name + mend);
    }
  }

  ParameterLayout layout_of(bool free_stops, bool free_lidars) const {
    ParameterLayout layout(stops(), lidars());
    std::vector<char> stop_used(recording_.stops.size(), 0);
    std::vector<char> lidar_used(recording_.lidar_sensors.size(), 0);
    for (std::size_t k = 0; k < recording_.patches.size(); ++k) {
      if (!solution_.use[k]) continue;
      stop_used[static_cast<std::size_t>(recording_.patches[k].stop)] = 1;
      lidar_used[static_cast<std::size_t>(recording_.patches[k].lidar)] = 1;
    }
    // The world is the solving LiDAR's frame at the first stop that is used.
    const auto first = std::find(stop_used.begin(), stop_used.end(), 1) - stop_used.begin();
    for (int j = 0; j < stops() && free_stops; ++j) {
      if (j != first && stop_used[static_cast<std::size_t>(j)]) layout.free_stop(j);
    }
    for (int i = 0; i < lidars() && free_lidars; ++i) {
      if (i != solving_ && lidar_used[static_cast<std::size_t>(i)]) layout.free_lidar(i);
    }
    return layout;
  }

  RefineInput input_of(const std::vector<char>& use) const {
    return {solution_.patches(recording_), solution_.noise, solution_.T_grid_G, use, solution_.adjust};
  }

  Expected<void> run_stage(const std::string& name, const ParameterLayout& layout, const std::vector<char>& use,
                           const std::vector<RefinePass>& passes) {
    StageReport& stage = clock_.begin(name);
    const RefineInput input = input_of(use);
    double done = 0.0;
    solution_.moves_on_one_grid.clear();
    for (RefinePass pass : passes) {
      if (pass.grids > 1) {
        if (is_at_rest()) break;
        if (solution_.moves_on_one_grid.empty()) solution_.moves_on_one_grid = solution_.refined.last_moves;
      }
      context_.reporter.progress(name, done / static_cast<double>(passes.size()));
      const bool loose = pass.map.gate_slack_m > 0.0;
      if (!loose) trust_.set_gates(pass);
      Expected<RefineSummary> refined = refine(input, layout, {pass}, context_, solution_.state);
      if (!refined) return refined.error();
      if (options_.on_pass) options_.on_pass(name, solution_.state);
      done += 1.0;
      stage.iterations += refined->iterations;
      stage.costs.insert(stage.costs.end(), refined->costs.begin(), refined->costs.end());
      solution_.refined = std::move(*refined);
      context_.reporter.debug(name + ": " + move_words(solution_.refined.last_moves));
      if (loose) {
        trust_.look_loosely(solution_.refined.map, solution_.state, pass.map.offset_floor_m);
      } else {
        trust_.look_at_gates(solution_.refined.map, solution_.state, pass.map.offset_floor_m);
      }
      solution_.unevenness_m = trust_.unevenness_m();
      if (!loose && solution_.refined.converged) break;
    }
    const RefineSummary& last = solution_.refined;
    if (context_.cancelled()) return cancelled_error();
    stage.cost_before = last.cost_before;
    stage.cost_after = last.cost_after;
    std::size_t observations = 0;
    for (const PlaneFeature& f : last.map.features) observations += f.observations.size();
    stage.counts = {{"cells", static_cast<double>(last.map.counts.cells)},
                    {"cells_used", static_cast<double>(last.map.counts.cells_used)},
                    {"cells_gated", static_cast<double>(last.map.counts.cells_gated)},
                    {"planes", static_cast<double>(last.map.features.size())},
                    {"observations", static_cast<double>(observations)},
                    {"passes", done}};
    context_.reporter.progress(name, 1.0);
    context_.reporter.debug(name + ": surfaces stand off their planes by " + std::to_string(1e3 * trust_.seen_m()) +
                            " mm beyond noise");
    tell(name);
    return {};
  }

  [[nodiscard]] bool is_at_rest() const {
    const std::vector<ExtrinsicMove>& moves = solution_.refined.last_moves;
    return std::all_of(moves.begin(), moves.end(),
                       [&](const ExtrinsicMove& move) { return is_rest(move, options_.require); });
  }

  // Where every LiDAR stands after a stage, for --log-level debug.
  void tell(const std::string& stage) const {
    for (int i = 0; i < lidars(); ++i) context_.reporter.debug(stage + ": " + place_words(i, solution_));
  }

  Expected<void> solve() {
    solution_.adjust = solving_priors(recording_, solution_.start, solving_guess_, options_);
    const std::vector<RefinePass> passes = standard_passes(max_tight_passes, max_settling_passes);
    RefinePass loose = passes.front();
    // Where it is the last, its map is what sigma is told from.
    if (options_.last_stage != LastStage::joint) {
      loose.map.with_rays = true;
      loose.map.by_cubes = false;
      loose.map.min_size_m = PlaneMapOptions{}.min_size_m;
    }
    std::vector<char> base_only = solution_.use;
    bool has_base = false;
    for (std::size_t k = 0; k < base_only.size(); ++k) {
      base_only[k] = base_only[k] && recording_.patches[k].lidar == solving_;
      has_base |= base_only[k] != 0;
    }
    if (has_base) {
      if (const auto done = run_stage("poses", layout_of(true, false), base_only, {loose}); !done) return done;
    }
    if (options_.last_stage == LastStage::poses) return {};
    if (has_base) {
      if (const auto done = run_stage("extrinsics", layout_of(false, true), solution_.use, {loose}); !done) {
        return done;
      }
    }
    if (options_.last_stage == LastStage::extrinsics) {
      solution_.layout = layout_of(false, true);
      return {};
    }
    return run_joint(has_base ? std::vector<RefinePass>(passes.begin() + 1, passes.end()) : passes);
  }

  // `passes`: the tight ones are run again where a stop had to be left out.
  Expected<void> run_joint(const std::vector<RefinePass>& passes) {
    solution_.layout = layout_of(true, true);
    const auto done = run_stage("joint", solution_.layout, solution_.use, passes);
    if (!done || !leave_out_misfits()) return done;
    solution_.layout = layout_of(true, true);
    std::vector<RefinePass> tight = passes;
    std::erase_if(tight, [](const RefinePass& pass) { return pass.map.gate_slack_m > 0.0; });
    return run_stage("joint without misfits", solution_.layout, solution_.use, tight);
  }

  // Those that stand in the wrong place. True when one was left out.
  bool leave_out_misfits() {
    const auto leave_out = [&](const std::vector<std::size_t>& misfits, const std::string& why) {
      for (const std::size_t j : misfits) {
        if (solution_.start.stop_known[j] == 0) continue;
        solution_.start.stop_known[j] = 0;
        context_.reporter.warn("stop " + std::to_string(recording_.stops[j].index) + " is left out: " + why);
      }
      return !misfits.empty();
    };
    const bool turned = leave_out(turned_otherwise(),
                                  "it would be turned otherwise than the gyro tells, by more than 3 degrees: too "
                                  "little of what was seen from it was seen from others; turn by smaller steps");
    const bool apart =
        leave_out(misfit_stops(stops(), recording_.patches, solution_.use, solution_.refined.map),
                  "little of what was seen from it lies on what was seen from others (its pose is wrong, the rig was "
                  "bumped, or they look elsewhere)");
    forget_lost_stops();
    const bool alone = leave_out_groups();
    return turned || apart || alone;
  }

  // Than the gyro tells in the frame of its own LiDAR, which no guess turned.
  [[nodiscard]] std::vector<std::size_t> turned_otherwise() const {
    if (!solution_.gyro_lidar) return {};
    std::vector<std::optional<Matrix3d>> turns(recording_.stops.size());
    std::vector<SE3> poses;
    for (int j = 0; j < stops(); ++j) {
      const auto sj = static_cast<std::size_t>(j);
      const std::optional<GyroTurn>& told = recording_.gyro_turns[sj];
      if (told && told->lidar == *solution_.gyro_lidar) turns[sj] = told->R_previous_this;
      poses.push_back(solution_.state.T_G_sensor(j, *solution_.gyro_lidar));
    }
    return misfit_turns(turns, poses, solution_.start.stop_known);
  }

  // A gyro or a trajectory says how they stand to the one before.
  [[nodiscard]] std::vector<char> told_stops() const {
    std::vector<char> told(recording_.stops.size(), 0);
    for (std::size_t j = 0; j < told.size(); ++j) {
      const bool by_gyro = j < recording_.R_previous_this.size() && recording_.R_previous_this[j];
      told[j] = by_gyro || !recording_.trajectory.empty() ? 1 : 0;
    }
    return told;
  }

  void forget_lost_stops() {
    for (std::size_t k = 0; k < recording_.patches.size(); ++k) {
      if (!solution_.start.stop_known[static_cast<std::size_t>(recording_.patches[k].stop)]) solution_.use[k] = 0;
    }
  }

  // What stands anywhere beside the others: each group fixes the LiDARs by itself, so that nothing else would tell. The
  // largest stays.
  bool leave_out_groups() {
    const auto count = recording_.stops.size();
    std::vector<char> used(count, 0);
    for (std::size_t k = 0; k < recording_.patches.size(); ++k) {
      if (solution_.use[k]) used[static_cast<std::size_t>(recording_.patches[k].stop)] = 1;
    }
    const std::vector<std::vector<std::size_t>> groups = stop_groups(used, told_stops(), solution_.refined.map);
    for (std::size_t g = 1; g < groups.size(); ++g) {
      std::vector<int> numbers;
      for (const std::size_t j : groups[g]) {
        numbers.push_back(recording_.stops[j].index);
        solution_.start.stop_known[j] = 0;
      }
      context_.reporter.warn(apart_words(numbers));
    }
    forget_lost_stops();
    return groups.size() > 1;
  }

  // Ranges that are too long by a constant move a LiDAR's place by nearly as much and hide in it; those of dark
  // surfaces do it by a part of that.
  Expected<void> take_out_range_errors() {
    if (options_.last_stage != LastStage::joint) return {};
    const std::vector<RefinePass> passes = standard_passes(max_tight_passes, max_settling_passes);
    std::optional<std::pair<LidarSolution, SurfaceTrust>> as_measured;
    for (int round = 0; round < most_range_rounds; ++round) {
      const std::optional<RangeFinding> finding = errors_that_stand_out(solution_);
      if (!finding) break;
      if (!as_measured) as_measured.emplace(solution_, trust_);
      trust_.distrust_noise();
      shorten_ranges(recording_, *finding, solution_);
      const auto done = run_stage("joint with ranges corrected", solution_.layout, solution_.use,
                                  std::vector<RefinePass>(passes.begin() + 1, passes.end()));
      if (!done) return done;
    }
    // They were found where surfaces were believed to be as flat as they look. Where they are not believed to be,
    // little is left of what is no error.
    if (as_measured && correction_is_refuted(solution_)) {
      context_.reporter.debug("ranges stay as they were measured: with surfaces less flat, nothing is wrong with them");
      std::tie(solution_, trust_) = *std::move(as_measured);
    }
    return {};
  }

  // What is left where the passes came to rest is where the grid happens to lie.
  Expected<void> even_out() {
    if (options_.last_stage != LastStage::joint) return {};
    StageReport& stage = clock_.begin("joint over several grids");
    context_.reporter.progress(stage.name, -1.0);
    RefinePass pass = standard_passes(1).back();
    pass.iterations = last_iterations;
    trust_.set_gates(pass);
    const std::vector<SE3> by_one_grid = extrinsics_from_base();
    const Expected<AdjustSummary> done =
        adjust_over_grids(input_of(solution_.use), solution_.layout, pass, grids_to_even_out, solution_.refined.map,
                          context_, solution_.state);
    if (!done) return done.error();
    stage.iterations = done->iterations;
    stage.cost_before = done->cost_before;
    stage.cost_after = done->cost_after;
    stage.costs = {done->costs};
    const std::vector<SE3> by_several = extrinsics_from_base();
    for (std::size_t i = 0; i < by_several.size(); ++i) {
      const SE3 shift = by_one_grid[i].inverse() * by_several[i];
      solution_.grid_shifts.push_back({shift.t.norm(), log_so3(shift.R).norm()});
    }
    if (options_.on_pass) options_.on_pass(stage.name, solution_.state);
    tell(stage.name);
    return {};
  }

  [[nodiscard]] std::vector<SE3> extrinsics_from_base() const {
    std::vector<SE3> out;
    const SE3 T_base_solving = solution_.state.T_base_sensor[static_cast<std::size_t>(base_)].inverse();
    for (const SE3& T : solution_.state.T_base_sensor) out.push_back(T_base_solving * T);
    return out;
  }

  // Weighed where it was solved, told in the base's frame.
  CalibrationResult judge() {
    freeze_open_directions(solution_);
    const SolutionQuality quality = weigh_solution(base_, solving_guess_, solution_);
    change_base(solving_, base_, solution_);
    begin_at_first_stop(solution_);
    CalibrationResult result = judge_solution(rig_, recording_, base_, guess_, options_, solution_, quality);
    forget_ranges_of_misplaced(result, solution_);
    return result;
  }

  CalibrationResult conclude() {
    clock_.begin("verdict");
    context_.reporter.progress("verdict", -1.0);
    CalibrationResult result = judge();
    if (const std::string words = range_words(result); !words.empty()) context_.reporter.warn(words);
    result.stages = clock_.take();
    if (options_.with_map) add_map(rig_, recording_, guess_, options_, solution_, result);
    return result;
  }

  const Rig& rig_;
  const LidarRecording& recording_;
  const std::vector<std::optional<SE3>>& guess_;
  const LidarCalibrationOptions& options_;
  const RunContext& context_;
  int base_ = 0;
  int solving_ = 0;                                // the LiDAR in whose frame it is solved
  std::vector<std::optional<SE3>> solving_guess_;  // seen from it
  LidarSolution solution_;
  SurfaceTrust trust_;
  StageClock clock_;
};

}  // namespace

Expected<CalibrationResult> calibrate_lidars(const Rig& rig, const LidarRecording& recording,
                                             const std::vector<std::optional<SE3>>& guess_T_base_sensor,
                                             const LidarCalibrationOptions& options, const RunContext& context,
                                             std::unique_ptr<LidarSolution>* solution) {
  Calibration calibration(rig, recording, guess_T_base_sensor, options, context);
  Expected<CalibrationResult> result = calibration.run();
  if (result && solution != nullptr) *solution = std::make_unique<LidarSolution>(calibration.take_solution());
  return result;
}

Expected<CalibrationResult> estimate_lidars(const Rig& rig, const LidarRecording& recording,
                                            const std::vector<std::optional<SE3>>& guess_T_base_sensor,
                                            const LidarCalibrationOptions& options, const RunContext& context,
                                            const WarmStart* warm, std::unique_ptr<LidarSolution>& solution) {
  Calibration calibration(rig, recording, guess_T_base_sensor, options, context);
  Expected<CalibrationResult> result = calibration.estimate(warm);
  if (result) solution = std::make_unique<LidarSolution>(calibration.take_solution());
  return result;
}

}  // namespace rigcal
