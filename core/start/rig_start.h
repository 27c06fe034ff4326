#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/base/run_context.h"
#include "core/start/registration.h"
#include "core/start/shape_match.h"
#include "core/voxel/rig_state.h"

namespace rigcal {

/// What is known before the first look at the surfaces.
struct StartInput {
  int stops = 0;
  int lidars = 0;
  int base = 0;
  std::vector<std::optional<SE3>> guess_T_base_sensor;   ///< One for each LiDAR.
  std::vector<std::optional<Matrix3d>> R_previous_this;  ///< By the gyro, one for each stop (the first: unused).
  /// A gyro in the base's own frame told them, so that they are right to a degree or two; else a rough guess of where
  /// the gyro sits turned them, or somebody's word.
  bool turns_are_own = false;
  std::vector<std::optional<SE3>> trajectory;  ///< Rough T_G_base; empty or one for each stop.
  /// By how much the rig turned since the stop before, rad, by the gyro of another sensor than the base; turns back
  /// have the other sign than turns forth. Empty, or one for each stop.
  std::vector<std::optional<double>> turned_rad;
  std::optional<Vector3d> axis;  ///< Of the table in the base frame; without one and without gyro it is searched for.
  /// More stops are to come: what was recorded so far is no full turn, whose steps could be assumed.
  bool goes_on = false;
  /// What the surfels were made of; null: LiDARs with few surfels have only those.
  const std::vector<PatchCells>* cells = nullptr;
};

/// A start good to a centimetre or two, and what was not found.
struct Start {
  RigState state;
  std::vector<SE3> given_T_G_base;  ///< The trajectory with its first pose made the world; empty without one.
  std::vector<char> stop_known;     ///< The base LiDAR (or the trajectory) places the rig at this stop.
  std::vector<char> lidar_known;
  /// The stops stand where a full turn in equal steps would have them: what was seen told no other way that fits, and
  /// does not show either that this one is right.
  bool has_assumed_steps = false;
  /// What the rig turned about (unit, base frame) where it is not the axis that was told, about which little of what
  /// was seen lies on itself.
  std::optional<Vector3d> other_axis;
  std::vector<RegistrationResult> matches;  ///< One for each LiDAR; scores 0 where nothing was searched.
  /// How the shapes of all that it saw place a LiDAR; only where its surfels are too few to be trusted alone.
  std::vector<std::optional<ShapeMatch>> shape_matches;
};

/// Poses of the rig by stop, T_first_base: seen from the first stop that is known.
[[nodiscard]] std::vector<SE3> poses_from_first(const Start& start);

/// Rough poses and extrinsics. Poses: from the trajectory, else by the gyro about a foot that the
/// scene shows, else by a search about the axis, or by equal steps all round or any steps where that fits clearly
/// better; then each LiDAR with a guess is laid on the base's map around it, by surfels or, where few, by shapes, one
/// without where its own panorama meets the base's; then all surfels on each other. Where stops slid off a table's turn
/// it holds them; those of a drive are placed by what all LiDARs saw.
[[nodiscard]] Expected<Start> find_start(const StartInput& input, const std::vector<PatchSurfels>& patches,
                                         const RunContext& context);

}  // namespace rigcal
