#pragma once

#include <optional>
#include <vector>

#include "core/start/surfels.h"

namespace rigcal {

/// A turn about an axis that stands still in a sensor's own frame: T_zero_j = (exp(angle_j axis), (I - R) foot), from
/// the frame at stop j to the one at angle zero.
struct AxisTurn {
  Vector3d axis = Vector3d::UnitZ();  ///< Unit.
  Vector3d foot = Vector3d::Zero();   ///< Its point nearest to the sensor.
  std::vector<double> angle;          ///< By stop, rad, right-handed.

  [[nodiscard]] SE3 pose(int stop) const;
};

/// The turn that poses of a rig come nearest to, in the rig's frame, its zero at the first known stop; nothing where it
/// hardly turned (less than 20 degrees in all). `off_m`: by how much the places of a point half a metre beside the axis
/// differ, root mean square.
struct TurnOfPoses {
  AxisTurn turn;
  double off_m = 0.0;

  /// Farther off than a vehicle that turns in place: half a metre.
  [[nodiscard]] bool drove() const { return off_m >= 0.5; }
};
[[nodiscard]] std::optional<TurnOfPoses> turn_of_poses(const std::vector<SE3>& T_G_base,
                                                       const std::vector<char>& stop_known);

/// How one LiDAR was carried round, from what it saw itself.
struct OwnTurn {
  AxisTurn turn;
  std::vector<SE3> T_zero_this;  ///< By stop, each a little off the turn where they wander.
  double score = 0.0;            ///< Balanced share of its surfels that lie on what it saw from other stops.
};

struct AxisSearchOptions {
  double step_sigma_rad = to_rad(0.3);  ///< How far each step between two stops may be off.
  double wander_m = 0.0;                ///< How far a stop may stand off the turn (0: none does).
  std::optional<Vector3d> axis;         ///< Known direction, in the sensor's frame: then none is searched for.
};

/// Searches all directions for the axis, given by how much the table had turned at each stop (`angle`, rad); the first
/// patch stands at its angle. What a LiDAR sees of one plane fits a turn the other way round as well, and parallel
/// walls more than that: all turns that fit nearly as well as the best are returned, the best first. `patches`: of one
/// LiDAR in the order of stops, at most one a stop. None with fewer than two patches or too few surfels.
[[nodiscard]] std::vector<OwnTurn> find_own_turns(const std::vector<PatchSurfels>& patches,
                                                  const std::vector<double>& angle, const AxisSearchOptions& options);

}  // namespace rigcal
