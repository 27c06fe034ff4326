#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "apps/capture/capture_summary.h"
#include "core/base/run_context.h"
#include "core/rig/rig.h"
#include "drivers/livox/device/driver.h"

namespace rigcal {

struct CaptureOptions {
  std::string out;
  std::uint64_t keep_bytes = 0;      ///< Keep only the newest packets; 0: all.
  std::optional<double> duration_s;  ///< Nothing: until told to stop.
  CaptureGoal goal;                  ///< `turns_itself` is set by the rig.
  StopSink* sink = nullptr;          ///< Gets the points of each stop as it is found, see LiveStops; may be null.
  std::function<bool()> is_enough;   ///< Asked ten times a second; true ends the capture. May be empty.
  /// Is to end the program with these words, where the disk takes nothing any more at the end; from another thread.
  /// Empty: the disk is waited for.
  std::function<void(const std::string& words)> give_up;
};

/// Records the LiDARs and cameras of a rig into a session until it is told to stop, its time is over or its stops are
/// in; looks out for them, turns a table that turns itself, tells `show` twice a second how they do, and writes into
/// session.json what happened. Trouble of a sensor or of the network ends nothing, nor do images of a camera that
/// cannot be written: the status of the camera says so. Errors: the session exists already; no LiDAR in the rig; no
/// interface, a port that is taken; no room on the disk (no session is made then); a table that cannot be had; the disk
/// (the session is closed then, and holds what was written).
[[nodiscard]] Expected<CaptureSummary> capture(const Rig& rig, const livox::DriverOptions& driver,
                                               const CaptureOptions& options, const RunContext& context,
                                               const std::function<void(const CaptureStatus&)>& show);

}  // namespace rigcal
