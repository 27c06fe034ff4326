#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "apps/capture_status.h"
#include "core/base/run_context.h"
#include "core/rig/rig.h"
#include "drivers/livox/device/driver.h"

namespace rigcal {

struct CaptureOptions {
  std::string out;
  std::uint64_t keep_bytes = 0;      ///< Keep only the newest packets; 0: all.
  std::optional<double> duration_s;  ///< Nothing: until told to stop.
};

struct CaptureSummary {
  std::string session;
  CaptureStatus status;
  std::vector<livox::InterfaceReport> interfaces;
  std::uint64_t control_datagrams = 0;  ///< Recorded, both directions.
  std::uint64_t recorded = 0;           ///< All datagrams, also those that --keep has thrown away since.
  std::uint64_t dropped_control = 0;
  std::optional<std::int64_t> forgotten_until_ns;
  std::vector<std::string> gaps;
  std::vector<std::string> notes;  ///< What was less good than it could be, with its mend.

  /// Every LiDAR and every camera has sent and was there to the end, and nothing got lost in this machine.
  [[nodiscard]] bool is_complete() const;
};

/// Records the LiDARs and cameras of a rig into a session until it is told to stop or its time is over; looks out for
/// them, tells `show` every second how they do, and writes into session.json what happened. Trouble of a sensor or of
/// the network ends nothing. Errors: the session exists already; no LiDAR in the rig; no interface, a port that is
/// taken; the disk (the session is closed then, and holds what was written).
[[nodiscard]] Expected<CaptureSummary> capture(const Rig& rig, const livox::DriverOptions& driver,
                                               const CaptureOptions& options, const RunContext& context,
                                               const std::function<void(const CaptureStatus&)>& show);

}  // namespace rigcal
