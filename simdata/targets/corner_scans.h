#pragma once

#include "simdata/targets/corner_clouds.h"

namespace rigcal::sim {

/// How far a LiDAR sees to either side, and up and down.
struct ScanField {
  double half_width_rad = to_rad(50.0);
  double half_height_rad = to_rad(30.0);
};

/// Two walls and a floor as two LiDARs see them, each in its own field only: x forwards onto the first wall, y sideways
/// (at right angles, onto the second), z up, and LiDAR a in the origin. All three go on for ever.
struct CornerScanOptions {
  Vector3d walls_m = {4.0, 2.6, 1.5};  ///< How far it is from a to the first wall, the second one and the floor.
  double angle_deg = 90.0;             ///< Between the walls.
  SE3 T_a_b = {};
  ScanField field_a = {};
  ScanField field_b = {};
  double tilt_rad = -0.15;  ///< Of the middle of either field.
  int rays = 8000;
  double max_range_m = 15.0;
  double sigma_m = 0.02;      ///< Of ranges.
  double b_too_long_m = 0.0;  ///< By which all ranges of b are off.
  std::uint64_t seed = 1;
};

[[nodiscard]] CornerClouds make_corner_scans(const CornerScanOptions& options);

}  // namespace rigcal::sim
