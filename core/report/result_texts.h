#pragma once

#include <string>

#include "core/base/error.h"
#include "core/quality/result.h"

namespace rigcal {

/// What a result folder holds, as text. All of it follows from the result alone, so the same result gives the same
/// bytes.

/// An Error where the result holds a number that is not finite, a sensor that has a transform and is `failed` (or the
/// other way round), or a base that is not among the sensors: such a result must not reach a file.
[[nodiscard]] Expected<void> check_result(const CalibrationResult& result);

/// extrinsics.yaml: T_base_sensor of every sensor that has one, 17 significant digits; docs/schema/extrinsics.json.
[[nodiscard]] std::string extrinsics_yaml(const CalibrationResult& result);

/// trajectory.tum: a line "stamp_s tx ty tz qx qy qz qw" of T_G_base a stop whose pose is known. The stamp is the
/// middle of the stop on the session clock, with nine decimals; the stop's number where the input had no times.
[[nodiscard]] std::string trajectory_tum(const CalibrationResult& result);

/// report.json: stages, counts, warnings, versions, status of each sensor, peak memory; docs/schema/report.json.
[[nodiscard]] std::string report_json(const CalibrationResult& result);

}  // namespace rigcal
