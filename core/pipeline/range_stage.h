#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/pipeline/lidar_result.h"
#include "core/planes/range_errors.h"

namespace rigcal {

/// What the planes of a solution make likely on top of what was taken out already.
struct RangeFinding {
  RangeLaw law = RangeLaw::none;
  RangeErrors errors;
};

/// Errors of ranges that stand out; nothing where there seem to be none, or next to nothing is left.
[[nodiscard]] std::optional<RangeFinding> errors_that_stand_out(const LidarSolution& solution);

/// Whether planes with ranges corrected make it likely beyond doubt that nothing had been wrong with them.
[[nodiscard]] bool correction_is_refuted(const LidarSolution& solution);

/// Takes the errors out of the patches and moves poses and extrinsics to where they are without them.
void shorten_ranges(const LidarRecording& recording, const RangeFinding& finding, LidarSolution& solution);

/// Of a LiDAR that failed ranges seem wrong because its place is, and those of the base where no other was placed: then
/// its ranges are taken as they were, for the map and the cameras.
void forget_ranges_of_misplaced(CalibrationResult& result, LidarSolution& solution);

/// All errors of ranges of a result in a sentence for a warning; empty where it has none.
[[nodiscard]] std::string range_words(const CalibrationResult& result);

}  // namespace rigcal
