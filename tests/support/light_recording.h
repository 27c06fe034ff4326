#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/pipeline/lidar_calibration.h"
#include "core/voxel/patch_of_points.h"
#include "simdata/rig/light_rig.h"

namespace rigcal {

/// A simulated run in memory as calibrate_lidars takes it, and what is true of it.
struct LightRecording {
  Rig rig;
  LidarRecording recording;
  std::vector<std::optional<SE3>> guess;
  RigState truth;
  std::int64_t points = 0;
};

inline std::vector<PatchCells> cells_of(const std::vector<Patch>& patches) {
  CellOptions options;
  options.keep_thinned = true;  // as `calibrate` does
  return cells_of_patches(patches, options);
}

/// Those stops of a run that are named, renumbered; the gyro's turns over the others are put together. All sensors of
/// the rig must be LiDARs.
inline LightRecording make_light_recording(const sim::LightRig& light, const std::vector<int>& stops) {
  LightRecording out;
  out.rig = light.rig;
  for (std::size_t k = 0; k < light.rig.sensors.size(); ++k) {
    out.recording.lidar_sensors.push_back(static_cast<int>(k));
    out.guess.push_back(light.rig.sensors[k].initial_T_base_sensor);
  }
  out.guess[static_cast<std::size_t>(light.rig.base)] = SE3{};
  std::vector<Patch> patches;
  for (std::size_t j = 0; j < stops.size(); ++j) {
    const auto stop = static_cast<std::size_t>(stops[j]);
    out.recording.stops.push_back({stops[j], 0, 0});
    Matrix3d R = Matrix3d::Identity();
    for (std::size_t k = j == 0 ? stop : static_cast<std::size_t>(stops[j - 1]); k < stop; ++k) {
      R = R * exp_so3(light.step_rotations[k]);
    }
    out.recording.R_previous_this.emplace_back();
    if (j > 0) out.recording.R_previous_this.back() = R;
    out.truth.T_G_base.push_back(light.T_G_base[static_cast<std::size_t>(stops[0])].inverse() * light.T_G_base[stop]);
    for (const Patch& patch : light.patches) {
      if (patch.stop != stops[j]) continue;
      patches.push_back(patch);
      patches.back().stop = static_cast<int>(j);
      out.points += static_cast<std::int64_t>(patch.points.size());
    }
  }
  out.recording.patches = cells_of(patches);
  out.truth.T_base_sensor = light.T_base_sensor;
  return out;
}

/// All stops.
inline LightRecording make_light_recording(const sim::LightRig& light) {
  std::vector<int> stops;
  for (std::size_t j = 0; j < light.T_G_base.size(); ++j) stops.push_back(static_cast<int>(j));
  return make_light_recording(light, stops);
}

}  // namespace rigcal
