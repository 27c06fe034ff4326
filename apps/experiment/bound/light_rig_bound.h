#pragma once

#include <limits>
#include <optional>
#include <vector>

#include "core/geometry/se3.h"
#include "simdata/rig/light_rig.h"
#include "simdata/scene/scene.h"

namespace rigcal::bound {

/// How far a surface is taken to be one plane.
struct SurfaceTrust {
  /// Edge of the cubes that surfaces are cut into, each piece a plane of its own; infinite: all that lies in one plane.
  double piece_m = std::numeric_limits<double>::infinity();
};

/// The bound (SurfaceBound) of each LiDAR of a run in `scene` whose patches still have their points. Which surface a
/// point is on is asked of the scene: the ray along its measured direction, from where its LiDAR truly stood. Left out
/// are points on curved surfaces, on panes, mirrors and wet ground, and those that stand more than five sigmas off the
/// surface behind them (people, shots that met two surfaces). Noise is that of the simulator, bleeding and biases not:
/// with these the bound is lower than what can be had. Empty where the shots leave something unknown.
[[nodiscard]] std::vector<std::optional<Matrix6d>> bound_of_light_rig(const sim::Scene& scene,
                                                                      const sim::LightRig& light,
                                                                      const SurfaceTrust& trust = {});

}  // namespace rigcal::bound
