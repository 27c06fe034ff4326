#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/corner/common_planes.h"
#include "core/planes/adjust.h"

namespace rigcal {

/// How one LiDAR came to its place.
struct LidarPlacement {
  bool known = false;
  std::string why_not;  ///< In words, where it is not known.
  PairPlacement pair;   ///< On `via`, at `stop`.
  int via = 0;
  int stop = 0;
};

/// All LiDARs in the frame of the base, as one solution: every plane that several saw at one moment holds them all.
struct RigPlacement {
  RigState state;  ///< The places of the stops are not told: each is a world of its own.
  std::vector<LidarPlacement> lidars;
  std::vector<PlaneFeature> features;
  ParameterLayout layout;
  AdjustOptions adjust;
  AdjustSummary adjusted;
  /// Root mean square by which the planes disagree over what their noise explains: 1 is right; 0: there are no more
  /// planes than needed.
  double misfit = 0.0;
};

/// Lays each LiDAR on the base, or on one that is known already where they see more in common, at the stop where they
/// fit best, then adjusts those that planes hold all at once; what shapes hold stays on the LiDAR that it was laid on.
/// `guess_T_base_sensor` has an entry for each LiDAR.
[[nodiscard]] RigPlacement place_rig(const RigViews& views, const std::vector<std::optional<SE3>>& guess_T_base_sensor);

}  // namespace rigcal
