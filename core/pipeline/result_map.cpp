#include "core/pipeline/result_map.h"

#include <algorithm>

#include "core/pipeline/fused_map.h"
#include "core/pipeline/lidar_result.h"
#include "core/pipeline/stage_clock.h"
#include "core/pipeline/surface_cuts.h"
#include "core/quality/shared_surfaces.h"

namespace rigcal {
namespace {

// Where each LiDAR of a recording stands among a result's sensors; points of maps and cuts know theirs by that.
std::vector<int> places_of(const std::vector<std::string>& lidars, const CalibrationResult& result) {
  std::vector<int> places;
  for (const std::string& lidar : lidars) {
    const auto at = std::find_if(result.sensors.begin(), result.sensors.end(),
                                 [&](const SensorResult& sensor) { return sensor.name == lidar; });
    places.push_back(static_cast<int>(at - result.sensors.begin()));
  }
  return places;
}

// What the calibration changed, for the eye: surfaces with the LiDARs where they were thought to be.
void compare_with_guess(const LidarRecording& recording, const std::vector<std::optional<SE3>>& guess,
                        const LidarSolution& solution, const std::vector<std::string>& names,
                        const std::vector<int>& places, CalibrationResult& result) {
  RigState before = solution.state;
  std::vector<char> use = solution.use;
  for (std::size_t i = 0; i < guess.size(); ++i) {
    if (guess[i]) before.T_base_sensor[i] = *guess[i];
  }
  for (std::size_t k = 0; k < use.size(); ++k) {
    use[k] = use[k] && guess[static_cast<std::size_t>(recording.patches[k].lidar)];
  }
  const std::vector<PlaneFeature>& features = solution.refined.map.features;
  result.shared_surfaces = shared_surfaces(features, before, solution.state, names);
  result.cuts = cut_surfaces(features, solution.patches(recording), before, solution.state, use, places);
  result.map_at_guess = fuse_map_to_look_at(solution.patches(recording), before, use, places);
}

}  // namespace

void add_map(const Rig& rig, const LidarRecording& recording,
             const std::vector<std::optional<SE3>>& guess_T_base_sensor, const LidarCalibrationOptions& options,
             const LidarSolution& solution, CalibrationResult& result) {
  std::vector<std::string> names;
  for (const int sensor : recording.lidar_sensors) names.push_back(rig.sensors[static_cast<std::size_t>(sensor)].name);
  const std::vector<int> places = places_of(names, result);
  StageClock clock;
  StageReport& stage = clock.begin("map");
  result.map = fuse_map(solution.patches(recording), solution.state, solution.use, places, options.map_size_m);
  stage.counts.emplace_back("points", static_cast<double>(result.map.size()));
  clock.begin("comparison with the guess");
  compare_with_guess(recording, guess_T_base_sensor, solution, names, places, result);
  for (StageReport& done : clock.take()) result.stages.push_back(std::move(done));
}

}  // namespace rigcal
