#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/base/run_context.h"
#include "core/edges/step_lines.h"
#include "core/quality/lidar_quality.h"
#include "core/rig/rig.h"
#include "core/start/surfels.h"
#include "core/voxel/cells.h"

namespace rigcal {

/// A turn of the rig since the stop before, in the frame of the LiDAR whose gyro told it.
struct GyroTurn {
  int lidar = 0;
  Matrix3d R_previous_this = Matrix3d::Identity();
};

/// A recording boiled down to what the LiDAR calibration needs. LiDARs are numbered in the order of `lidar_sensors`,
/// stops in the order of `stops`.
struct LidarRecording {
  std::vector<int> lidar_sensors;  ///< Index in the rig of each LiDAR; others of the rig fail.
  std::vector<Stop> stops;         ///< `index` is the number users see.
  std::vector<PatchCells> patches;
  /// By stop, of each LiDAR, those without a patch included: points too far to be used (CellOptions); empty: not
  /// counted.
  std::vector<std::vector<std::uint64_t>> too_far;
  std::vector<std::optional<Matrix3d>> R_previous_this;  ///< Of the base, by the gyro; empty: no gyro.
  std::vector<std::optional<GyroTurn>> gyro_turns;       ///< The same as they were told, by stop; may be empty.
  std::vector<std::optional<double>> turned_rad;         ///< By how much, by any gyro: neither axis nor sign.
  std::vector<std::optional<SE3>> trajectory;            ///< Rough T_G_base; empty: none.
  bool trajectory_is_prior = false;                      ///< It comes from the user: see `pose_prior`.
  /// What depends on one patch alone, of each, where somebody has found it already (while the rest was still recorded);
  /// empty: it is found when it is needed, and the same.
  std::vector<PatchSurfels> surfels;
  std::vector<PatchOutlines> outlines;  ///< With `beam_widths`, for cameras.

  /// How many points of a LiDAR were too far to be used, in all stops.
  [[nodiscard]] std::uint64_t too_far_of(std::size_t lidar) const {
    std::uint64_t sum = 0;
    for (const auto& of_stop : too_far) sum += lidar < of_stop.size() ? of_stop[lidar] : 0;
    return sum;
  }
  [[nodiscard]] bool saw_too_far(std::size_t lidar) const { return too_far_of(lidar) > 0; }
};

enum class LastStage { poses, extrinsics, joint };

struct LidarCalibrationOptions {
  Requirement require;
  LastStage last_stage = LastStage::joint;
  /// Sigmas of a given trajectory: directions in which pose and extrinsic cannot be told apart stay near it.
  double pose_prior_m = 0.05;
  double pose_prior_rad = to_rad(2.0);
  double map_size_m = 0.02;  ///< Of the fused map; 0: all points that were kept.
  /// Told the name of the stage and where everything stands after the start and after each pass (a map built anew, then
  /// solved): for experiments on how soon a calibration is right.
  std::function<void(const std::string& stage, const RigState& state)> on_pass = {};
  bool with_map = true;  ///< Else `add_map` is still to be called: a map is for the eye, and takes its time.
  /// Whether a place that does not fit the rough poses makes a LiDAR `weak`. Not in experiments whose guesses are far
  /// off on purpose.
  bool judges_guesses = true;
};

struct LidarSolution;

/// The targetless method for LiDARs: start, poses, extrinsics, joint adjustment, verdict. All of it runs in the frame
/// of a LiDAR that the data choose (core/pipeline/solving_base.h); the result is in the base's. `guess_T_base_sensor`
/// has an entry for each LiDAR. Errors: no stop, no base in the recording and no way round it, cancelled. A sensor that
/// cannot be solved is no error but `failed` in the result. `solution`, if not null, gets where the calibration ended,
/// for what builds on it.
[[nodiscard]] Expected<CalibrationResult> calibrate_lidars(const Rig& rig, const LidarRecording& recording,
                                                           const std::vector<std::optional<SE3>>& guess_T_base_sensor,
                                                           const LidarCalibrationOptions& options,
                                                           const RunContext& context,
                                                           std::unique_ptr<LidarSolution>* solution = nullptr);

}  // namespace rigcal
