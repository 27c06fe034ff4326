#include "tests/support/small_run.h"

#include <gtest/gtest.h>

#include "core/base/run_context.h"
#include "core/rig/rig.h"
#include "simdata/scene/scene_file.h"

namespace rigcal {

std::string small_rig(const std::string& more_sensors, const std::string& more_extrinsics) {
  return R"(rigcal: 1
name: test
base: avia
sensors:
  avia: {type: livox_avia, broadcast_code: "3JEDHC900100791", ip: 192.168.1.179, topic: /livox/lidar_179,
         imu_topic: /livox/imu_179}
  mid40: {type: livox_mid40, broadcast_code: "0TFDG3B00600551", ip: 192.168.1.21, topic: livox/lidar_21}
)" + more_sensors +
         R"(initial_extrinsics:
  mid40: {translation: [-0.15, 0.0, -0.15], rotation_xyzw: [0.0, 0.0, -0.965926, 0.258819]}
)" + more_extrinsics +
         "turntable: {driver: manual, axis: [0, 0, 1]}\n";
}

std::string small_camera(const std::string& name, const std::string& pixel_format) {
  return "  " + name + ":\n    type: camera\n    driver: aravis\n    topic: /" + name +
         "\n    exposure_us: 5000\n    pixel_format: " + pixel_format + R"(
    intrinsics: {model: radtan, width: 640, height: 512, fx: 431.5, fy: 431.5, cx: 319.5, cy: 255.5,
                 distortion: [-0.1, 0.09, 3.0e-4, -2.0e-4, 0.0]}
)";
}

sim::RunOptions hurried_run(int stops, double dwell_s) {
  sim::RunOptions run;
  run.turntable.stops = stops;
  run.turntable.dwell_s = dwell_s;
  run.turntable.turn_s = 0.5;
  run.turntable.swing_rad = 2e-4;
  run.turntable.initial_still_s = 1.0;
  return run;
}

void simulate_courtyard(const std::string& rig_yaml, const sim::RunOptions& run, const std::filesystem::path& session) {
  const auto rig = parse_rig(rig_yaml, "rig.yaml");
  ASSERT_TRUE(rig) << rig.error().message();
  const auto scene = sim::load_scene("courtyard");
  ASSERT_TRUE(scene) << scene.error().message();
  SilentReporter silent;
  const auto made = sim::simulate_session(*scene, *rig, run, session.string(), {silent});
  ASSERT_TRUE(made) << made.error().message();
}

}  // namespace rigcal
