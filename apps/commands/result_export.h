#pragma once

#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/quality/result.h"
#include "core/report/result_formats.h"

namespace rigcal {

/// What became of a result.
struct ResultExport {
  std::vector<std::string> sensors;   ///< Written, in the order of the file.
  std::vector<std::string> left_out;  ///< Failed ones.
  std::vector<std::string> warnings;
  Status status = Status::good;  ///< The worst of the sensors.
  bool is_judged = true;         ///< See CalibrationResult.
};

/// Writes a result folder or an extrinsics.yaml in the format of another tool. `rig_path` may be empty; the rig file
/// tells which sensors are cameras, and their intrinsics, and without it the report.json of the folder tells the
/// cameras that had images, and a rig file that stands for a result its own. Errors: no result, a report.json of a
/// newer release, an unreadable rig file, a path that exists already, the disk.
[[nodiscard]] Expected<ResultExport> export_result_file(const std::string& path, const std::string& rig_path,
                                                        ResultFormat format, const std::string& out);

}  // namespace rigcal
