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
  /// Shapes hold it, or one on the way to the base that it was laid on: no planes join it with the base, and it stays
  /// on `via`.
  bool follows = false;
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
/// fit best, then adjusts those that planes join with the base all at once; what shapes hold stays on the LiDAR that it
/// was laid on, and so does what was laid on it.
/// `guess_T_base_sensor` has an entry for each LiDAR.
[[nodiscard]] RigPlacement place_rig(const RigViews& views, const std::vector<std::optional<SE3>>& guess_T_base_sensor);

}  // namespace rigcal
