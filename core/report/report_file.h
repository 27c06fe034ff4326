#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/rig/rig.h"

namespace rigcal {

/// What of a report.json others read again.
struct ReportFile {
  std::vector<std::string> warnings;                   ///< Of the run.
  std::vector<std::string> cameras;                    ///< Names of those that it tells of: not of all that failed.
  std::map<std::string, CameraIntrinsics> intrinsics;  ///< Of these, where it has them.
};

/// Reads the report.json of a result folder; nothing where there is none, or another program's. Errors: what is there
/// cannot be read (cut, damaged), a newer format.
[[nodiscard]] Expected<std::optional<ReportFile>> read_report(const std::string& folder);

}  // namespace rigcal
