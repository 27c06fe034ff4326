#pragma once

#include <vector>

#include "core/start/registration.h"
#include "core/start/surfels.h"

namespace rigcal {

/// How a LiDAR may sit on a rig, from what it saw itself.
struct Mounting {
  SE3 T_base_sensor;
  double score = 0.0;  ///< Share of its surfels that lie on what it saw from other stops.
};

/// Hand-eye calibration by surfaces: the rig's poses are known and not a turn about one axis only (it drove), so a
/// mounting decides how the LiDAR was carried, and the right one lays what it saw from all stops on itself. All
/// rotations are tried by stops that look nearly the same way, which a wrong place of the LiDAR displaces least; the
/// best are refined with ever more of the others. A rig that drives on level ground leaves the LiDAR's place along the
/// axis of its turns open. `patches`: of one LiDAR in the order of stops, at most one a stop; `T_zero_base`: by stop.
/// The likeliest first, none that fits clearly worse; none with fewer than two patches or too few surfels.
[[nodiscard]] std::vector<Mounting> find_mountings(const std::vector<PatchSurfels>& patches,
                                                   const std::vector<SE3>& T_zero_base);

/// The axis that the rig turned about most, base frame at zero.
[[nodiscard]] Vector3d main_axis(const std::vector<SE3>& T_zero_base);

/// Each mounting moved along `axis` (base frame at zero), by up to two metres, to where what the LiDAR saw meets the
/// map best: the likeliest places of each.
[[nodiscard]] std::vector<SE3> mountings_on_map(const SurfelIndex& map, const MovingSurfels& moving,
                                                const std::vector<Mounting>& mountings, const Vector3d& axis);

}  // namespace rigcal
