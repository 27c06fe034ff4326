#pragma once

#include <optional>
#include <vector>

#include "core/pipeline/lidar_calibration.h"

namespace rigcal {

struct CornerCalibrationOptions {
  Requirement require;
  double map_size_m = 0.02;  ///< Of the fused map; 0: all points that were kept.
};

/// The planes method: extrinsics of LiDARs from the planes that they see at one moment, without motion and without a
/// guess. Of a recording of many stops at most `most_stops` are used, evenly; each counts for itself, how the rig
/// turned between them is not asked. `guess_T_base_sensor` has an entry for each LiDAR; they only choose between places
/// that look alike. The patches need their thinned points. Errors: no stop, no base among the LiDARs, cancelled. A
/// LiDAR that cannot be solved is no error but `failed` in the result.
[[nodiscard]] Expected<CalibrationResult> calibrate_by_planes(
    const Rig& rig, const LidarRecording& recording, const std::vector<std::optional<SE3>>& guess_T_base_sensor,
    const CornerCalibrationOptions& options, const RunContext& context);

}  // namespace rigcal
