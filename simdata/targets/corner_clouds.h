#pragma once

#include <cstdint>
#include <vector>

#include "core/geometry/se3.h"

namespace rigcal::sim {

/// The synthetic corner of the planes paper (IV 2019): a left and a right wall at an angle, both at right angles on the
/// floor, 10 m each way, and points that lie on nothing. Two LiDARs stand in the middle of it.
struct CornerCloudOptions {
  double angle_deg = 90.0;  ///< Between the left and the right wall.
  double size_m = 10.0;
  int points = 7500;  ///< A third on each plane.
  double sigma_m = 0.1;
  int stray_points = 2000;
  double stray_sigma_m = 5.0;
  SE3 T_a_b = {};
  bool shared_noise = false;  ///< Both clouds are the same points; else each is drawn anew.
  std::uint64_t seed = 1;
};

/// One cloud in its LiDAR's frame (x forwards, z up). `plane` has for each point 0 left, 1 right, 2 floor, -1 none.
struct CornerCloud {
  std::vector<Vector3d> points;
  std::vector<int> plane;
};

struct CornerClouds {
  CornerCloud a;
  CornerCloud b;
};

[[nodiscard]] CornerClouds make_corner_clouds(const CornerCloudOptions& options);

/// Rz(a) Ry(b) Rx(c) of the paper's three numbers a, b, c and the translation: its configurations 1 and 2.
[[nodiscard]] SE3 paper_configuration(int number);

}  // namespace rigcal::sim
