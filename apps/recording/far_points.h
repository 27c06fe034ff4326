#pragma once

#include <string>
#include <vector>

#include "core/pipeline/lidar_calibration.h"
#include "core/rig/rig.h"

namespace rigcal {

/// Of LiDARs most of whose points lie farther than cells reach, a sentence each.
[[nodiscard]] std::vector<std::string> far_point_warnings(const Rig& rig, const LidarRecording& recording);

}  // namespace rigcal
