#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/corner/pair_calibration.h"
#include "core/voxel/plane_feature.h"
#include "core/voxel/rig_state.h"

namespace rigcal {

/// What the LiDARs of a rig saw at some moments, the same for all of them.
struct RigViews {
  std::vector<std::string> names;  ///< Of the LiDARs.
  int base = 0;
  std::vector<std::vector<std::optional<PlaneView>>> stops;  ///< views[stop][lidar]
};

/// A plane that several LiDARs saw at one moment, as each of them saw it, in its own frame.
struct CommonPlane {
  struct Seen {
    int lidar = 0;
    SeenPlane plane;
    double share = 0.95;  ///< Of the points near it that lie on it.
  };
  int stop = 0;
  std::vector<Seen> seen;
};

/// The planes of all stops that at least two of the LiDARs with `use` saw, with these where `state` has them.
[[nodiscard]] std::vector<CommonPlane> find_common_planes(const RigViews& views, const std::vector<char>& use,
                                                          const RigState& state, const PlaneMatchTolerance& tolerance);

/// The same planes fitted to the points in those parts of them only that at least two LiDARs saw: surfaces are uneven,
/// and at their borders chance decides. Planes without common parts are left out.
[[nodiscard]] std::vector<CommonPlane> on_common_parts(const RigViews& views, const std::vector<CommonPlane>& planes,
                                                       const RigState& state);

/// What an adjustment needs of them.
[[nodiscard]] std::vector<PlaneFeature> features_of(const std::vector<CommonPlane>& planes, const RigState& state);

}  // namespace rigcal
