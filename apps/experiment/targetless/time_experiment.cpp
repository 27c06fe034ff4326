#include "apps/experiment/targetless/time_experiment.h"

#include <array>
#include <iterator>
#include <limits>

#include "apps/experiment/targetless/trials.h"
#include "core/base/median.h"
#include "core/base/seconds.h"
#include "core/planes/merge_planes.h"
#include "core/planes/refine.h"
#include "core/voxel/patch_of_points.h"
#include "simdata/scene/random_vectors.h"
#include "simdata/scene/scene_file.h"

namespace rigcal::targetless {
namespace {

constexpr std::uint64_t off_stream = 950;
constexpr double off_m = 0.005;
constexpr double off_deg = 0.03;
constexpr double icp_reach_m = 0.3;
constexpr int repetitions = 5;
// Where every point asks, each takes seconds: fewer, but not one, which whatever else the machine does would double.
constexpr int repetitions_of_all = 3;
constexpr std::size_t all_points = std::numeric_limits<std::size_t>::max();
constexpr std::array<const char*, 3> stage_names{"pose", "extrinsic", "global"};

RigState nearly_right(const sim::LightRig& light, std::uint64_t seed) {
  Random random(seed, off_stream);
  RigState state{light.T_G_base, light.T_base_sensor};
  const auto spoil = [&](SE3& T) {
    const Vector3d turn = to_rad(off_deg) * sim::random_direction(random);
    const Vector3d shift = off_m * sim::random_direction(random);
    T = T * SE3{exp_so3(turn), shift};
  };
  for (std::size_t j = 1; j < state.T_G_base.size(); ++j) spoil(state.T_G_base[j]);
  for (std::size_t i = 0; i < state.T_base_sensor.size(); ++i) {
    if (static_cast<int>(i) != light.rig.base) spoil(state.T_base_sensor[i]);
  }
  return state;
}

ParameterLayout layout_of(const std::string& stage, const RigState& state, int base) {
  ParameterLayout layout(static_cast<int>(state.T_G_base.size()), static_cast<int>(state.T_base_sensor.size()));
  for (int j = 1; j < layout.stops() && stage != "extrinsic"; ++j) layout.free_stop(j);
  for (int i = 0; i < layout.lidars() && stage != "pose"; ++i) {
    if (i != base) layout.free_lidar(i);
  }
  return layout;
}

// The middle one of some measurements of each.
template <class Once>
StageSeconds middle_of(const std::string& method, const std::string& stage, int times, const Once& once) {
  StageSeconds out{method, stage, 0.0, 0.0, 0};
  std::vector<double> match;
  std::vector<double> solve;
  for (int k = 0; k < times; ++k) {
    const StageSeconds measured = once();
    match.push_back(measured.match_s);
    solve.push_back(measured.solve_s);
    out.matched = measured.matched;
  }
  out.match_s = median(std::move(match));
  out.solve_s = median(std::move(solve));
  return out;
}

// As core/planes/refine.h does it, with a clock between map and solution.
StageSeconds one_pass(const SimulatedSet& set, const std::string& stage, RigState state) {
  const RefinePass pass = standard_passes(1).back();
  const std::vector<PatchCells>& patches = set.recording.patches;
  const int base = set.light.rig.base;
  std::vector<char> use;
  for (const PatchCells& patch : patches) use.push_back(stage != "pose" || patch.lidar == base);
  const std::vector<NoiseModel> noise(state.T_base_sensor.size());
  const ParameterLayout layout = layout_of(stage, state, base);
  AdjustOptions adjustment;
  adjustment.form = pass.form;
  adjustment.max_iterations = pass.iterations;
  StageSeconds out;
  const auto begin = SteadyClock::now();
  PlaneMap map = build_plane_map(patches, state, noise, SE3{}, pass.map, use);
  MergeOptions merge;
  merge.tolerance_m = pass.merge_tolerance_m;
  std::vector<PlaneFeature> merged = merge_coplanar(map.features, merge);
  std::move(merged.begin(), merged.end(), std::back_inserter(map.features));
  const auto matched = SteadyClock::now();
  adjust(map.features, layout, adjustment, state);
  const auto end = SteadyClock::now();
  for (const PlaneFeature& feature : map.features) out.matched += feature.observations.size();
  out.match_s = seconds_between(begin, matched);
  out.solve_s = seconds_between(matched, end);
  return out;
}

StageSeconds one_icp_iteration(PairwiseIcp& icp, int base, const std::string& stage, RigState state) {
  StageSeconds out;
  const ParameterLayout layout = layout_of(stage, state, base);
  const std::optional<int> only = stage == "pose" ? std::optional(base) : std::nullopt;
  const auto begin = SteadyClock::now();
  out.matched = icp.match(state, icp_reach_m, only);
  const auto matched = SteadyClock::now();
  icp.solve(layout, state);
  out.match_s = seconds_between(begin, matched);
  out.solve_s = seconds_between(matched, SteadyClock::now());
  return out;
}

}  // namespace

Expected<TimeExperiment> measure_times(const LidarExperimentOptions& options, const RunContext& context) {
  if (context.cancelled()) return cancelled_error();
  context.reporter.progress("time", 0.0);
  SetOptions set_options;
  set_options.seed = options.seed;
  set_options.points = options.points;
  set_options.stops = options.stops;
  const Expected<sim::Scene> scene = sim::load_scene(set_options.scene);
  if (!scene) return scene.error();
  const Expected<SimulatedSet> set = make_set(set_options, *scene);
  if (!set) return set.error();
  TimeExperiment out;
  out.patches = static_cast<int>(set->patches.size());
  for (const Patch& patch : set->patches) out.points += patch.points.size();
  const auto begin = SteadyClock::now();
  const std::vector<PatchCells> cells = cells_of_patches(set->patches, CellOptions{});
  const auto celled = SteadyClock::now();
  PairwiseIcp icp(set->patches, IcpOptions{});
  out.ours_prepare_s = seconds_between(begin, celled);
  out.icp_prepare_s = seconds_between(celled, SteadyClock::now());
  IcpOptions thorough;
  thorough.queries = all_points;
  PairwiseIcp icp_of_all(set->patches, thorough);
  const RigState state = nearly_right(set->light, options.seed);
  double done = 0.0;
  for (const char* stage : stage_names) {
    if (context.cancelled()) return cancelled_error();
    context.reporter.progress("time", ++done / 4.0);
    const int base = set->light.rig.base;
    out.stages.push_back(middle_of("rigcal", stage, repetitions, [&] { return one_pass(*set, stage, state); }));
    out.stages.push_back(
        middle_of("ICP", stage, repetitions, [&] { return one_icp_iteration(icp, base, stage, state); }));
    out.stages.push_back(middle_of("ICP, all points", stage, repetitions_of_all,
                                   [&] { return one_icp_iteration(icp_of_all, base, stage, state); }));
  }
  context.reporter.progress("time", 1.0);
  return out;
}

}  // namespace rigcal::targetless
