#pragma once

#include <cstdint>
#include <vector>

#include "core/start/surfels.h"
#include "tests/support/make_cells.h"
#include "tests/support/make_planes.h"

namespace rigcal {

/// What the base LiDAR of a rig saw of a room from a table that was turned by these steps.
struct TurningRun {
  std::vector<Matrix3d> R_G_base{Matrix3d::Identity()};
  std::vector<PatchSurfels> base_patches;

  TurningRun(const std::vector<double>& steps_deg, std::uint64_t seed) {
    const Vector3d foot(0.28, -0.12, 0.0);
    for (const double deg : steps_deg) R_G_base.push_back(R_G_base.back() * exp_so3(to_rad(deg) * Vector3d::UnitZ()));
    RigState truth;
    truth.T_base_sensor = {SE3{}};
    for (const Matrix3d& R : R_G_base) truth.T_G_base.push_back({R, foot - R * foot});
    Random random(seed);
    base_patches = extract_surfels(
        make_patches(make_room(), truth, View{150.0, to_rad(50.0), {0.02, 0.0, 0.0005}}, random), SurfelOptions{});
  }
  [[nodiscard]] int stops() const { return static_cast<int>(R_G_base.size()); }
};

/// A full turn in twelve steps, each a degree or so off.
inline std::vector<double> turn_by_hand(std::uint64_t seed) {
  Random random(seed);
  std::vector<double> steps;
  for (int i = 0; i < 11; ++i) steps.push_back(30.0 + 1.2 * random.normal());
  return steps;
}

}  // namespace rigcal
