#include "apps/light_runs.h"

#include "core/voxel/patch_of_points.h"

namespace rigcal {

LidarRecording light_recording(sim::LightRig& light, bool with_gyro) {
  LidarRecording out;
  for (std::size_t i = 0; i < light.rig.sensors.size(); ++i) out.lidar_sensors.push_back(static_cast<int>(i));
  for (std::size_t j = 0; j < light.T_G_base.size(); ++j) {
    out.stops.push_back({static_cast<int>(j), 0, 0});
    if (!with_gyro) continue;
    out.R_previous_this.emplace_back();
    out.gyro_turns.emplace_back();
    if (j == 0) continue;
    out.R_previous_this.back() = exp_so3(light.step_rotations[j - 1]);
    out.gyro_turns.back() = GyroTurn{light.rig.base, *out.R_previous_this.back()};
  }
  out.patches = cells_of_patches(light.patches, CellOptions{});
  for (Patch& patch : light.patches) patch.points = {};
  return out;
}

}  // namespace rigcal
