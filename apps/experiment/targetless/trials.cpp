#include "apps/experiment/targetless/trials.h"

#include <algorithm>

#include "simdata/scene/scene_file.h"

namespace rigcal::targetless {
namespace {

constexpr double right_m = 0.02;
constexpr double right_rad = to_rad(0.2);

bool is_right(const RigError& error) {
  return error.worst_translation_m <= right_m && error.worst_rotation_rad <= right_rad;
}

}  // namespace

const RigError& Trial::after(std::size_t iteration) const { return errors[std::min(iteration, errors.size() - 1)]; }

bool Trial::is_right(std::size_t iteration) const {
  const bool is_end = iteration + 1 >= errors.size();
  if (is_end && std::find(T_base_sensor.begin(), T_base_sensor.end(), std::nullopt) != T_base_sensor.end())
    return false;
  return targetless::is_right(after(iteration));
}

std::optional<int> Trial::right_from() const {
  std::optional<int> from;
  for (std::size_t k = errors.size(); k > 0 && is_right(k - 1); --k) from = static_cast<int>(k - 1);
  return from;
}

Expected<Ground> make_ground(const SetOptions& options, const sim::Scene& scene) {
  Expected<SimulatedSet> set = make_set(options, scene);
  if (!set) return set.error();
  PairwiseIcp icp(set->patches, IcpOptions{});
  set->patches = {};
  return Ground{std::move(*set), std::move(icp)};
}

Expected<std::vector<Ground>> make_grounds(const GroundOptions& options, const RunContext& context) {
  std::vector<Ground> out;
  for (const std::string& name : options.scenes) {
    if (context.cancelled()) return cancelled_error();
    context.reporter.progress("scenes", static_cast<double>(out.size()) / static_cast<double>(options.scenes.size()));
    const Expected<sim::Scene> scene = sim::load_scene(name);
    if (!scene) return scene.error();
    SetOptions set_options;
    set_options.scene = name;
    set_options.seed = options.seed;
    set_options.points = options.points;
    set_options.stops = options.stops;
    Expected<Ground> ground = make_ground(set_options, *scene);
    if (!ground) return ground.error();
    out.push_back(std::move(*ground));
  }
  return out;
}

Expected<Trial> try_ours(const SimulatedSet& set, const std::vector<SE3>& guess, const RunContext& context) {
  Trial out;
  out.errors.push_back(error_of(guess, set));
  LidarCalibrationOptions options;
  options.with_map = false;
  options.on_pass = [&](const std::string& stage, const RigState& state) {
    // The base's own poses: no extrinsic moves.
    if (stage != "poses") out.errors.push_back(error_of(state.T_base_sensor, set));
  };
  SilentReporter silent;
  const auto result =
      calibrate_lidars(set.light.rig, set.recording, {guess.begin(), guess.end()}, options, {silent, context.stop});
  if (!result) return result.error();
  for (const SensorResult& sensor : result->sensors) out.T_base_sensor.push_back(sensor.T_base_sensor);
  for (const StageReport& stage : result->stages) out.seconds += stage.name == "verdict" ? 0.0 : stage.wall_s;
  return out;
}

Trial try_icp(Ground& ground, const std::vector<SE3>& guess, int iterations, bool stop_when_settled,
              const RunContext& context) {
  Trial out;
  out.errors.push_back(error_of(guess, ground.set));
  IcpRunOptions options;
  options.base = ground.set.light.rig.base;
  options.iterations = iterations;
  options.stop_when_settled = stop_when_settled;
  options.after_iteration = [&](const RigState& state) {
    out.errors.push_back(error_of(state.T_base_sensor, ground.set));
  };
  RigState state = ground.set.start(guess);
  const IcpRun run = run_icp(ground.icp, options, context, state);
  out.T_base_sensor.assign(state.T_base_sensor.begin(), state.T_base_sensor.end());
  out.seconds = run.pose_s + run.match_s + run.solve_s;
  return out;
}

}  // namespace rigcal::targetless
