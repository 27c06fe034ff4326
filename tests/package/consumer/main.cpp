// Prints where the LiDARs of a recording sit: consumer RECORDING [RIG]
#include <cstdio>
#include <iostream>
#include <string>

#include "apps/recording/recording.h"
#include "core/pipeline/lidar_calibration.h"

int main(int argc, char** argv) {
  if (argc < 2) return 2;
  rigcal::SilentReporter silent;
  const rigcal::RunContext context{silent};
  const auto recording = rigcal::read_recording({argv[1], argc > 2 ? argv[2] : "", ""}, rigcal::CellOptions{}, context);
  if (!recording) {
    std::cerr << recording.error().message() << "\n";
    return 3;
  }
  const rigcal::Rig& rig = recording->rig;
  std::vector<std::optional<rigcal::SE3>> guesses;
  for (const int sensor : recording->lidar.lidar_sensors) {
    guesses.push_back(rig.sensors[static_cast<std::size_t>(sensor)].initial_T_base_sensor);
  }
  const auto result = rigcal::calibrate_lidars(rig, recording->lidar, guesses, {}, context);
  if (!result) {
    std::cerr << result.error().message() << "\n";
    return 3;
  }
  for (const rigcal::SensorResult& sensor : result->sensors) {
    if (!sensor.T_base_sensor) continue;
    const rigcal::Vector3d& t = sensor.T_base_sensor->t;
    std::printf("%s -> %s: %.4f %.4f %.4f m\n", sensor.name.c_str(), rig.base_sensor().name.c_str(), t.x(), t.y(),
                t.z());
  }
  return 0;
}
