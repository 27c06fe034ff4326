#pragma once

#include "simdata/rig/light_rig.h"

namespace rigcal::sim {

struct RandomMounting {
  double reach_m = 1.0;  ///< How far a LiDAR may be from the middle of the table's top.
  /// Only mountings from which the rig's turn shows surfaces of all directions: 40 % of the shots return from nearer
  /// than 60 m, and at least 4 % of the squares of their normals lie along each direction. A LiDAR that sees nothing
  /// but the sky or the floor cannot be calibrated by anybody.
  bool sees_all_directions = true;
  /// Only mountings in which every LiDAR shares surfaces of all directions with those before it: at least 3 % of the
  /// squares of the normals of all that it sees lie along each direction on places (to a metre) that another saw
  /// from the same side. One that sees the ceiling while the others see the floor has an unknown height.
  bool shares_surfaces = false;
};

/// A rig that nobody drew: an AVIA and three MID-40, each turned any way and anywhere around the middle of the table's
/// top, which itself stands beside the table's axis as the options say. The first LiDAR is the base; the rig has no
/// initial extrinsics. Errors: those of make_light_rig; no such mounting after many tries.
[[nodiscard]] Expected<LightRig> make_random_rig(const Scene& scene, const LightRigOptions& options,
                                                 const RandomMounting& mounting);

}  // namespace rigcal::sim
