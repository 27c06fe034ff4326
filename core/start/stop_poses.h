#pragma once

#include <vector>

#include "core/start/rig_start.h"

namespace rigcal {

/// How firmly stops are held where they were placed while their surfels are laid on each other.
struct StopHold {
  double translation_m = 0.0;
  double rotation_rad = 0.0;
};

/// Stops come right by decimetres. So do they go wrong, where what they saw leaves a direction open.
constexpr StopHold loose_hold{0.1, to_rad(1.0)};
/// Of stops of a table that turned about a point, which holds what the scene leaves open.
constexpr StopHold firm_hold{0.01, to_rad(0.2)};

/// Where the base stood at each stop: by the trajectory, else by its turns (gyro, or a search about the axis) about a
/// foot that the scene shows. Sets `state.T_G_base` (metres; G is the base's frame at the first stop) and `stop_known`.
/// `base_patches`: of the base, in the order of stops.
void place_stops(const StartInput& input, const std::vector<PatchSurfels>& base_patches, Start& start);

/// Those of stops that are known.
[[nodiscard]] std::vector<PatchSurfels> known_of(std::vector<PatchSurfels> patches, const Start& start);

/// Whether a table turned about a known axis by steps of which some are not known.
[[nodiscard]] bool has_unknown_steps(const StartInput& input);

/// Whether no trajectory tells where the rig stood, and nothing by how much it turned from some stop to the next: what
/// goes by the angles takes those steps for equal ones all round.
[[nodiscard]] bool turns_in_assumed_steps(const StartInput& input);

/// Where the base stood if these need not be alike; only the stops that hang together are known then. Sets what
/// `place_stops` does.
void place_by_evidence(const StartInput& input, const std::vector<PatchSurfels>& base_patches, Start& start);

/// Where the base stood if most are equal and go all round, and the table turned right-handed about its axis (`way` 1)
/// or the other way round (-1). Sets what `place_stops` does.
void place_in_equal_steps(const StartInput& input, const std::vector<PatchSurfels>& base_patches, double way,
                          Start& start);

/// From one stop to the next.
struct StopStep {
  double turn_rad = 0.0;
  double move_m = 0.0;
};

/// How far the base usually turned and moved from one stop that is known to the next: medians; 0 where fewer than two
/// are. `known`: one for each pose.
[[nodiscard]] StopStep usual_step(const std::vector<SE3>& T_G_base, const std::vector<char>& known);

/// Lays the surfels of `patches`, all seen by the base, on each other; the poses so far hold what the scene leaves
/// open.
void refine_stops(const StartInput& input, const std::vector<PatchSurfels>& patches, const StopHold& hold,
                  Start& start);

/// Where the turns by the gyro do not lay what the base saw on itself: it may have turned about another axis (a gyro on
/// another sensor, whose guess is off), or have been driven.
void try_other_ways(const StartInput& input, const std::vector<PatchSurfels>& base_patches, Start& start);

}  // namespace rigcal
