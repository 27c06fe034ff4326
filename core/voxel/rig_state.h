#pragma once

#include <vector>

#include "core/geometry/se3.h"

namespace rigcal {

/// What the LiDAR calibration estimates. Indices: stops 0 .. M - 1 and LiDARs 0 .. L - 1 as the pipeline numbers them.
struct RigState {
  std::vector<SE3> T_G_base;       ///< Pose of the rig at each stop.
  std::vector<SE3> T_base_sensor;  ///< Extrinsics of each LiDAR; identity for the base.

  [[nodiscard]] SE3 T_G_sensor(int stop, int lidar) const {
    return T_G_base[static_cast<std::size_t>(stop)] * T_base_sensor[static_cast<std::size_t>(lidar)];
  }
};

}  // namespace rigcal
