#include "apps/experiment/base_experiment.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "apps/experiment/experiment_json.h"
#include "apps/experiment/independent_trials.h"
#include "apps/experiment/light_runs.h"
#include "core/base/random.h"
#include "simdata/scene/scene_file.h"

namespace rigcal {
namespace {

// What a user knows who calls this LiDAR the base: the same guesses, or none, and the turns of the first LiDAR's gyro,
// in the base's axes where the guess tells these.
struct SeenFrom {
  Rig rig;
  LidarRecording recording;
  std::vector<std::optional<SE3>> guess;

  SeenFrom(const Rig& first, const LidarRecording& of_first, bool with_guess, std::size_t base)
      : rig(first), recording(of_first) {
    rig.base = static_cast<int>(base);
    const SE3 T_this_first = first.sensors[base].initial_T_base_sensor->inverse();
    for (Sensor& sensor : rig.sensors) {
      sensor.initial_T_base_sensor = T_this_first * *sensor.initial_T_base_sensor;
      guess.push_back(with_guess ? sensor.initial_T_base_sensor : std::nullopt);
    }
    guess[base] = SE3{};
    for (auto& R : recording.R_previous_this) {
      if (!R || base == 0) continue;
      R = with_guess ? std::optional<Matrix3d>(T_this_first.R * *R * T_this_first.R.transpose()) : std::nullopt;
    }
  }
};

struct Found {
  std::optional<SE3> T_base_sensor;
  bool is_good = false;
};
using Extrinsics = std::vector<Found>;

Expected<Extrinsics> calibrated(const SeenFrom& seen, const RunContext& context) {
  SilentReporter silent;
  LidarCalibrationOptions options;
  options.with_map = false;
  const auto result = calibrate_lidars(seen.rig, seen.recording, seen.guess, options, {silent, context.stop});
  if (!result) return result.error();
  Extrinsics out;
  for (const SensorResult& sensor : result->sensors)
    out.push_back({sensor.T_base_sensor, sensor.status == Status::good});
  return out;
}

void compare(const Extrinsics& first, const Extrinsics& other, BaseRow& row) {
  for (std::size_t a = 0; a < first.size(); ++a) {
    if (!first[a].T_base_sensor || !other[a].T_base_sensor) continue;
    for (std::size_t b = 0; b < first.size(); ++b) {
      if (!first[b].T_base_sensor || !other[b].T_base_sensor) continue;
      const SE3 of_first = first[a].T_base_sensor->inverse() * *first[b].T_base_sensor;
      const SE3 of_other = other[a].T_base_sensor->inverse() * *other[b].T_base_sensor;
      const double mm = 1e3 * (of_first.t - of_other.t).norm();
      const double deg = to_deg(rotation_distance(of_first.R, of_other.R));
      row.worst_mm = std::max(row.worst_mm, mm);
      row.worst_deg = std::max(row.worst_deg, deg);
      if (!first[a].is_good || !first[b].is_good || !other[a].is_good || !other[b].is_good) continue;
      row.good_worst_mm = std::max(row.good_worst_mm, mm);
      row.good_worst_deg = std::max(row.good_worst_deg, deg);
    }
  }
}

Expected<void> try_rig(const BaseExperimentOptions& options, std::uint64_t seed, const RunContext& context,
                       BaseRow& row) {
  row.seed = seed;
  row.scene = light_run_scenes[row.seed % light_run_scenes.size()];
  const Expected<sim::Scene> scene = sim::load_scene(row.scene);
  if (!scene) return scene.error();
  sim::LightRigOptions light_options;
  light_options.seed = row.seed;
  light_options.shots_per_patch = options.points;
  Random random(row.seed, 810);
  light_options.turntable.stops = 12 + static_cast<int>(random.below(13));
  Expected<sim::LightRig> light = sim::make_light_rig(*scene, light_options);
  if (!light) return light.error();
  const LidarRecording recording = light_recording(*light, options.with_gyro);
  row.stops = static_cast<int>(recording.stops.size());
  row.lidars = static_cast<int>(light->rig.sensors.size());
  std::vector<Extrinsics> all;
  for (std::size_t base = 0; base < light->rig.sensors.size(); ++base) {
    Expected<Extrinsics> found = calibrated(SeenFrom(light->rig, recording, options.with_guess, base), context);
    if (!found) return found.error();
    all.push_back(std::move(*found));
    compare(all.front(), all.back(), row);
  }
  for (std::size_t i = 0; i < light->rig.sensors.size(); ++i) {
    const auto lacks_it = [&](const Extrinsics& found) { return !found[i].T_base_sensor; };
    row.failed += std::any_of(all.begin(), all.end(), lacks_it) ? 1 : 0;
  }
  return {};
}

}  // namespace

Expected<std::vector<BaseRow>> try_bases(const BaseExperimentOptions& options, const RunContext& context) {
  std::vector<BaseRow> rows(static_cast<std::size_t>(options.rigs));
  const auto done = independent_trials(options.rigs, "bases", context, [&](int k) {
    return try_rig(options, options.seed + static_cast<std::uint64_t>(k), context, rows[static_cast<std::size_t>(k)]);
  });
  if (!done) return done.error();
  return rows;
}

std::string base_experiment_text(const std::vector<BaseRow>& rows) {
  std::string text =
      "One rig, calibrated with each of its LiDARs as the base: the largest difference between two LiDARs\n";
  for (const BaseRow& row : rows)
    text += fmt::format("  {} {} ({} stops): {:.2g} mm {:.2g} deg, of good ones {:.2g} mm {:.2g} deg, {} failed\n",
                        row.seed, row.scene, row.stops, row.worst_mm, row.worst_deg, row.good_worst_mm,
                        row.good_worst_deg, row.failed);
  return text;
}

std::string base_experiment_json(const std::vector<BaseRow>& rows) {
  nlohmann::ordered_json json = experiment_head("base");
  json["rows"] = nlohmann::ordered_json::array();
  for (const BaseRow& row : rows)
    json["rows"].push_back({{"seed", row.seed},
                            {"scene", row.scene},
                            {"stops", row.stops},
                            {"lidars", row.lidars},
                            {"failed", row.failed},
                            {"worst_mm", row.worst_mm},
                            {"worst_deg", row.worst_deg},
                            {"good_worst_mm", row.good_worst_mm},
                            {"good_worst_deg", row.good_worst_deg}});
  return json_text(json);
}

}  // namespace rigcal
