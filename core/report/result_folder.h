#pragma once

#include <string>

#include "core/base/error.h"
#include "core/quality/result.h"
#include "core/rig/rig.h"

namespace rigcal {

/// An Error where `path` exists and is not a result folder that may be replaced: a file, or a folder that holds
/// anything rigcal did not write; or where no folder can be made (kind system). Ask before a long calculation;
/// write_result_folder asks again.
[[nodiscard]] Expected<void> check_result_target(const std::string& path);

/// Writes extrinsics.yaml, trajectory.tum, report.json, report.html, map.ply and, in the folder `overlays`,
/// <camera>_<stop>.jpg and of a map <camera>_<stop>_map.jpg; `rig` (or null) tells the page what kind of sensors they
/// are. The folder appears, or takes the place of an older result, as a whole and only when all of it is on the disk;
/// after an Error nothing has changed.
[[nodiscard]] Expected<void> write_result_folder(const CalibrationResult& result, const std::string& path,
                                                 const Rig* rig = nullptr);

}  // namespace rigcal
