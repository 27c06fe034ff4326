#pragma once

#include <string>

#include "core/base/error.h"
#include "core/quality/result.h"

namespace rigcal {

/// Writes the fused cloud as binary PLY: x, y, z (float, metres, world frame G), colour (where no camera saw it, grey
/// from the reflectivity), intensity
/// (reflectivity 0 .. 255) and sensor (index; the names stand in the header's comment). The points are taken as they
/// are. An Error where the disk refuses.
[[nodiscard]] Expected<void> write_map_ply(const CalibrationResult& result, const std::string& path);

}  // namespace rigcal
