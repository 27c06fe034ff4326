#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/pipeline/camera_stage.h"
#include "core/pipeline/lidar_calibration.h"

namespace rigcal {

struct BoardCalibrationOptions {
  Requirement require;
  bool refine_intrinsics = false;  ///< Also where the rig file has none: then radtan, from the images' size.
  std::uint64_t seed = 1;          ///< Of the draws in clouds with rings.
};

/// What was recorded of the board.
struct BoardRecording {
  const std::vector<Stop>& stops;
  /// All near points of each LiDAR; Patch::sensor is its index in the rig, Patch::stop counts in `stops`.
  const std::vector<Patch>& patches;
  const std::vector<CameraRecording>& cameras;
};

/// Whether the rig file has a board that can be found. Errors, without a place: no board in it, or one with markers
/// where these are not known.
[[nodiscard]] Expected<void> check_board(const Rig& rig);

/// The checkerboard method: LiDARs and cameras by the board of the rig file, shown at several stops. The base may be a
/// camera where the rig has no LiDAR. `guess_T_base_sensor` has an entry for each sensor of the rig; guesses only
/// choose between places that explain the boards equally well. Errors: those of `check_board`, no stop, cancelled. A
/// sensor that cannot be placed is no error but `failed`.
[[nodiscard]] Expected<CalibrationResult> calibrate_by_boards(
    const Rig& rig, const BoardRecording& recording, const std::vector<std::optional<SE3>>& guess_T_base_sensor,
    const BoardCalibrationOptions& options, const RunContext& context);

}  // namespace rigcal
