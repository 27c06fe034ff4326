#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/pipeline/lidar_result.h"
#include "core/planes/range_offsets.h"

namespace rigcal {

/// Range offsets that the planes of a solution make likely, on top of what was taken out already; nothing where there
/// seem to be none, or next to nothing is left.
[[nodiscard]] std::optional<RangeOffsets> offsets_that_stand_out(const LidarSolution& solution);

/// Takes the offsets out of the patches and moves poses and extrinsics to where they are without them.
void shorten_ranges(const LidarRecording& recording, const RangeOffsets& offsets, LidarSolution& solution);

/// Of a LiDAR that failed ranges seem wrong because its place is, and those of the base where no other was placed: then
/// its ranges are taken as they were, for the map and the cameras.
void forget_offsets_of_misplaced(CalibrationResult& result, LidarSolution& solution);

/// All offsets of a result in a sentence for a warning; empty where it has none.
[[nodiscard]] std::string range_offset_words(const CalibrationResult& result);

}  // namespace rigcal
