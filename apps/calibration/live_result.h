#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "apps/calibration/live_calibration.h"

namespace rigcal {

/// What a capture that calibrates as it goes has found in the end.
struct LiveResult {
  CalibrationResult result;
  std::string out;                      ///< The result folder.
  double solved_s = 0.0;                ///< From the end of the recording until the extrinsics stood,
  double wall_s = 0.0;                  ///< and until the folder was complete.
  std::vector<StopEstimate> estimates;  ///< What was known on the way, where somebody asked.
};

/// Which of the stops a session has no longer, or not whole, after all that came until `forgotten_until_ns` was thrown
/// away (`capture --keep`), and what that means for a result that has them all; nothing where none is concerned.
[[nodiscard]] std::optional<std::string> lost_stops_warning(std::span<const StopRecord> stops,
                                                            std::int64_t forgotten_until_ns);

/// Solves all stops of a session whose recording has ended, and writes the result folder: the cells are there already,
/// and what follows is `rigcal calibrate SESSION`, with the same numbers to the bit. `reading` is what LiveStops gave.
/// `forgotten_until_ns`: up to here the session's packets were thrown away; the result is then warned of stops that the
/// session has no longer.
/// `solved` is called when the numbers stand (and how long that took); the pictures come after it. Errors: as `rigcal
/// calibrate SESSION`.
[[nodiscard]] Expected<LiveResult> finish_live(
    const std::string& session, const StopReading& reading, std::optional<std::int64_t> forgotten_until_ns,
    LiveCalibration& calibration, const std::string& out, const RunContext& context,
    const std::function<void(const CalibrationResult&, double)>& solved = {});

}  // namespace rigcal
