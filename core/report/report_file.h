#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/base/error.h"

namespace rigcal {

/// What of a report.json others read again.
struct ReportFile {
  std::vector<std::string> warnings;  ///< Of the run.
  std::vector<std::string> cameras;   ///< Names of those that had images and intrinsics.
};

/// Reads the report.json of a result folder; nothing where it is missing, unreadable or not ours. Error: a newer
/// format.
[[nodiscard]] Expected<std::optional<ReportFile>> read_report(const std::string& folder);

}  // namespace rigcal
