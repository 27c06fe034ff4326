#pragma once

#include <vector>

#include "core/start/rig_start.h"
#include "core/voxel/patch_of_points.h"
#include "simdata/rig/light_rig.h"

namespace rigcal {

/// A simulated run in memory as find_start takes it, and what is true of it.
struct LightRun {
  /// Enough of each patch for a start.
  static constexpr int shots_per_patch = 6000;

  sim::LightRig truth;
  std::vector<PatchSurfels> surfels;
  StartInput input;  ///< Without guesses but for the base's own, without turns and without axis.

  explicit LightRun(sim::LightRig light) : truth(std::move(light)) {
    surfels = extract_surfels(cells_of_patches(truth.patches, CellOptions{}), SurfelOptions{});
    input.stops = static_cast<int>(truth.T_G_base.size());
    input.lidars = static_cast<int>(truth.T_base_sensor.size());
    input.guess_T_base_sensor.resize(truth.T_base_sensor.size());
    input.guess_T_base_sensor[0] = SE3{};
  }

  void give_gyro() {
    input.R_previous_this.emplace_back();
    for (const Vector3d& step : truth.step_rotations) input.R_previous_this.emplace_back(exp_so3(step));
  }
};

}  // namespace rigcal
