#pragma once

#include "apps/recording/recording.h"
#include "apps/recording/stop_reader.h"

namespace rigcal {

/// A dump or a bag becomes a recording: points, stops, cells, in one pass and in memory that does not grow with the
/// file. A dump in which a device names itself only after its first points is read twice.
/// `keep_points_within_m`: see RecordingPaths.
[[nodiscard]] Expected<Recording> read_stream(const StreamSource& source, const CellOptions& cells,
                                              double keep_points_within_m, const RunContext& context);

/// The same where the recording is read already: `reading` is what `read_stops` gave, `lidar` what `CellSink` made of
/// it. Errors: what keeps it from being calibrated.
[[nodiscard]] Expected<Recording> make_recording(const StreamSource& source, const StopReading& reading,
                                                 LidarRecording lidar, const RunContext& context);

}  // namespace rigcal
