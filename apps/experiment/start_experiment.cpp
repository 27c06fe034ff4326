#include "apps/experiment/start_experiment.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "apps/experiment/bound/light_rig_bound.h"
#include "apps/experiment/independent_trials.h"
#include "apps/experiment/light_runs.h"
#include "core/base/median.h"
#include "core/base/random.h"
#include "core/pipeline/lidar_calibration.h"
#include "simdata/rig/random_rig.h"
#include "simdata/scene/random_vectors.h"
#include "simdata/scene/scene_file.h"

namespace rigcal {
namespace {

constexpr double right_m = 0.005;
constexpr double right_rad = to_rad(0.05);
// Of a table's axis in a rig file.
constexpr double axis_error_rad = to_rad(1.5);

const std::vector<StartCase>& all_cases() {
  static const std::vector<StartCase> cases = [] {
    std::vector<StartCase> out(8);
    out[0].name = "gyro";
    out[1].name = "nothing";
    out[1].with_gyro = false;
    out[2].name = "vehicle";
    out[2].wander_m = 0.1;
    out[2].wander_deg = 1.0;
    out[3] = out[2];
    out[3].name = "figure8";
    out[3].drives = true;
    out[4].name = "guess";
    out[4].guess_m = 1.0;
    out[4].guess_deg = 20.0;
    out[5].name = "apart";
    out[5].shares_surfaces = false;
    out[6].name = "table";
    out[6].with_gyro = false;
    out[6].guess_m = 0.2;
    out[6].guess_deg = 10.0;
    out[6].knows_axis = true;
    out[7] = out[6];
    out[7].name = "unequal";
    out[7].step_range_deg = {10.0, 60.0};
    return out;
  }();
  return cases;
}

struct Thrown {
  sim::Scene scene;
  sim::LightRig light;
};

Expected<Thrown> throw_rig(const StartCase& kind, std::uint64_t seed, int points) {
  Expected<sim::Scene> scene = sim::load_scene(light_run_scenes[seed % light_run_scenes.size()]);
  if (!scene) return scene.error();
  sim::LightRigOptions options;
  options.seed = seed;
  options.shots_per_patch = points;
  Random random(seed, 800);
  options.turntable.stops = 12 + static_cast<int>(random.below(13));
  if (kind.step_range_deg) {
    options.turntable.stops = 8 + static_cast<int>(random.below(9));
    options.turntable.step_range_deg = kind.step_range_deg;
  }
  if (kind.wander_m > 0.0) sim::let_wander(kind.wander_m, kind.wander_deg, options.turntable);
  if (kind.drives) {
    // It turns by one and a half full turns.
    options.turntable.stops = 24 + static_cast<int>(random.below(13));
    options.turntable.drive_m = scene->name == "room" ? 1.2 : 3.0;
  }
  sim::RandomMounting mounting;
  mounting.shares_surfaces = kind.shares_surfaces;
  Expected<sim::LightRig> light = sim::make_random_rig(*scene, options, mounting);
  if (!light) return light.error();
  return Thrown{std::move(*scene), std::move(*light)};
}

std::vector<std::optional<SE3>> guesses(const StartCase& kind, const sim::LightRig& light, std::uint64_t seed) {
  std::vector<std::optional<SE3>> out(light.T_base_sensor.size());
  Random random(seed, 801);
  for (std::size_t i = 0; i < out.size(); ++i) {
    const Vector3d turn = to_rad(kind.guess_deg) * sim::random_direction(random);
    const Vector3d shift = kind.guess_m * sim::random_direction(random);
    const SE3& T = light.T_base_sensor[i];
    if (kind.guess_m >= 0.0) out[i] = SE3{T.R * exp_so3(turn), T.t + shift};
  }
  out[0] = SE3{};
  return out;
}

// As a rig file has it.
void tell_axis(std::uint64_t seed, sim::LightRig& light) {
  Random random(seed, 802);
  const Vector3d off = axis_error_rad * sim::random_direction(random).cross(light.axis).normalized();
  light.rig.turntable.emplace().axis = exp_so3(off) * light.axis;
}

struct Errors {
  std::vector<double> mm;
  std::vector<double> deg;
  std::vector<double> start_s;
};

double worst_of(const std::vector<double>& values) {
  return values.empty() ? 0.0 : *std::max_element(values.begin(), values.end());
}

// What became of one rig.
struct Trial {
  std::uint64_t seed = 0;
  std::string scene;
  std::size_t stops = 0;
  std::vector<SE3> truth;
  CalibrationResult result;
  /// What the noise allows each LiDAR; made where one is not right.
  std::vector<std::optional<Matrix6d>> bounds;
};

// How far a LiDAR is off.
struct Miss {
  double mm = 0.0;
  double deg = 0.0;
  bool is_right = false;
};

Miss miss_of(const SE3& estimate, const SE3& truth) {
  Miss out{1e3 * (estimate.t - truth.t).norm(), to_deg(rotation_distance(estimate.R, truth.R)), false};
  out.is_right = out.mm <= 1e3 * right_m && to_rad(out.deg) <= right_rad;
  return out;
}

bool is_right(const Trial& trial, std::size_t i) {
  const std::optional<SE3>& estimate = trial.result.sensors[i].T_base_sensor;
  return estimate && miss_of(*estimate, trial.truth[i]).is_right;
}

// Root of the summed variances along the axes.
std::string sigmas(const Matrix6d& covariance) {
  return fmt::format("{:.1f}, {:.3f}", 1e3 * std::sqrt(covariance.diagonal().tail<3>().sum()),
                     to_deg(std::sqrt(covariance.diagonal().head<3>().sum())));
}

std::string what_became(const Trial& trial, std::size_t i) {
  const SensorResult& sensor = trial.result.sensors[i];
  if (!sensor.T_base_sensor) return fmt::format(" {} failed;", sensor.name);
  const Miss miss = miss_of(*sensor.T_base_sensor, trial.truth[i]);
  std::string text = fmt::format(" {} {} {:.1f} mm {:.3f} deg (sigma {}", sensor.name, to_string(sensor.status),
                                 miss.mm, miss.deg, sigmas(sensor.covariance));
  if (trial.bounds[i]) text += fmt::format("; the noise allows {}", sigmas(*trial.bounds[i]));
  return text + ");";
}

void judge(const Trial& trial, StartRow& row, Errors& errors) {
  const CalibrationResult& result = trial.result;
  bool all_right = true;
  bool all_flagged = true;
  std::string miss = fmt::format("{} {} ({} stops):", trial.seed, trial.scene, trial.stops);
  for (std::size_t i = 1; i < result.sensors.size(); ++i) {
    const SensorResult& sensor = result.sensors[i];
    ++row.lidars;
    if (is_right(trial, i)) {
      const Miss off = miss_of(*sensor.T_base_sensor, trial.truth[i]);
      ++row.lidars_right;
      if (sensor.status != Status::good) ++row.right_but_flagged;
      errors.mm.push_back(off.mm);
      errors.deg.push_back(off.deg);
    } else {
      all_right = false;
      if (sensor.status == Status::good) all_flagged = false;
      miss += what_became(trial, i);
    }
  }
  ++row.rigs;
  if (all_right) {
    ++row.right;
  } else {
    ++(all_flagged ? row.flagged : row.wrong);
    row.misses.push_back(std::move(miss));
  }
  errors.start_s.push_back(result.stages.front().wall_s);
}

}  // namespace

std::vector<std::string> start_case_names() {
  std::vector<std::string> names;
  for (const StartCase& kind : all_cases()) names.push_back(kind.name);
  return names;
}

namespace {

Expected<void> try_rig(const StartCase& kind, std::uint64_t seed, int points, const RunContext& context, Trial& out) {
  Expected<Thrown> rig = throw_rig(kind, seed, points);
  if (!rig) return rig.error();
  sim::LightRig& light = rig->light;
  if (kind.knows_axis) tell_axis(seed, light);
  SilentReporter silent;
  LidarCalibrationOptions options;
  options.with_map = false;
  // A result is good where it is known to be what the experiment calls right.
  options.require = {right_m, right_rad};
  // They are off by more than a rough pose may be, and are not what is judged.
  options.judges_guesses = false;
  auto result = calibrate_lidars(light.rig, light_recording(light, kind.with_gyro), guesses(kind, light, seed), options,
                                 {silent, context.stop});
  if (!result) return result.error();
  out = {seed, rig->scene.name, light.T_G_base.size(), light.T_base_sensor, std::move(*result), {}};
  for (std::size_t i = 1; i < out.truth.size() && out.bounds.empty(); ++i) {
    if (is_right(out, i)) continue;
    // The points were given up.
    rig = throw_rig(kind, seed, points);
    if (!rig) return rig.error();
    out.bounds = bound::bound_of_light_rig(rig->scene, rig->light);
  }
  return {};
}

Expected<StartRow> try_case(const StartCase& kind, const StartExperimentOptions& options, const RunContext& context) {
  std::vector<Trial> trials(static_cast<std::size_t>(options.rigs));
  const auto done = independent_trials(options.rigs, kind.name, context, [&](int k) {
    return try_rig(kind, options.seed + static_cast<std::uint64_t>(k), options.points, context,
                   trials[static_cast<std::size_t>(k)]);
  });
  if (!done) return done.error();
  StartRow row;
  row.kind = kind;
  Errors errors;
  for (const Trial& trial : trials) judge(trial, row, errors);
  row.median_mm = median(errors.mm);
  row.worst_mm = worst_of(errors.mm);
  row.median_deg = median(errors.deg);
  row.worst_deg = worst_of(errors.deg);
  row.start_median_s = median(errors.start_s);
  row.start_worst_s = worst_of(errors.start_s);
  return row;
}

// Up to guesses that say nothing any more.
Expected<void> try_basin(const StartExperimentOptions& options, const RunContext& context,
                         std::vector<StartRow>& rows) {
  for (double scale = 1.0; scale < 9.5; scale *= 1.5) {
    StartCase kind;
    kind.guess_m = scale;
    kind.guess_deg = std::min(180.0, 20.0 * scale);
    kind.name = fmt::format("guess {:.1f} m {:.0f} deg", kind.guess_m, kind.guess_deg);
    Expected<StartRow> row = try_case(kind, options, context);
    if (!row) return row.error();
    rows.push_back(std::move(*row));
    if (rows.back().right < 0.99 * options.rigs) break;
  }
  return {};
}

}  // namespace

Expected<std::vector<StartRow>> try_starts(const StartExperimentOptions& options, const RunContext& context) {
  std::vector<StartRow> rows;
  for (const StartCase& kind : all_cases()) {
    const bool is_named = std::find(options.cases.begin(), options.cases.end(), kind.name) != options.cases.end();
    if (!is_named && (!options.cases.empty() || options.basin)) continue;
    Expected<StartRow> row = try_case(kind, options, context);
    if (!row) return row.error();
    rows.push_back(std::move(*row));
  }
  if (options.basin) {
    if (const auto done = try_basin(options, context, rows); !done) return done.error();
  }
  return rows;
}

}  // namespace rigcal
