#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/error.h"
#include "core/io/extrinsics_file.h"
#include "core/quality/result.h"
#include "core/rig/rig.h"

namespace rigcal {

/// The files of other tools that a result can be written as; docs/manual.md tells what each holds.
enum class ResultFormat { ros2_tf, urdf, autoware, kalibr, opencv, colmap, mlcc, fast_livo, json };

/// The names on the command line, in the order of the enumeration.
[[nodiscard]] const std::vector<std::string>& result_format_names();
[[nodiscard]] std::optional<ResultFormat> result_format(std::string_view name);

/// The part of a result that its extrinsics.yaml holds; the base comes first where the file does not list it. Error: a
/// base that no frame can be called, at `place`.
[[nodiscard]] Expected<CalibrationResult> result_from(const ExtrinsicsFile& file, const std::string& place = {});

struct ExportedResult {
  std::string text;
  std::vector<std::string> sensors;   ///< Those whose transforms are in it, in its order.
  std::vector<std::string> warnings;  ///< What could not be written, in sentences.
};

/// The text of a result in one of the formats. `rig` (or null) tells which sensors are cameras, and their intrinsics.
/// Failed sensors have no transform and are left out, with a warning. Errors, without a place: a line too few would
/// give the others the wrong names; of a format of cameras all have failed; of mlcc there is no LiDAR beside the base.
[[nodiscard]] Expected<ExportedResult> export_result(const CalibrationResult& result, const Rig* rig,
                                                     ResultFormat format);

}  // namespace rigcal
