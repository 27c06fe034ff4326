#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "apps/capture/capture_status.h"
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
};

struct CaptureSummary {
  std::string session;
  CaptureStatus status;
  std::vector<livox::InterfaceReport> interfaces;
  std::uint64_t control_datagrams = 0;  ///< Recorded, both directions.
  std::uint64_t recorded = 0;           ///< All datagrams, also those that --keep has thrown away since.
  std::uint64_t dropped_control = 0;
  livox::ControlCounters control;
  std::optional<std::int64_t> forgotten_until_ns;
  std::int64_t end_ns = 0;  ///< Session time at which it was ended; closing comes after that.
  std::vector<std::string> gaps;
  std::vector<std::string> notes;      ///< What was less good than it could be, with its mend.
  double closing_s = 0.0;              ///< From its end until all was recorded, the devices free and the stops read.
  std::optional<StopReading> reading;  ///< What the stops were found from; nothing where that failed.

  /// Every LiDAR and every camera has sent, without interruption and to the end, and as it was set up to, nothing got
  /// lost in this machine, and all stops that were asked for are in.
  [[nodiscard]] bool is_complete() const { return shortfalls().empty(); }
  /// What keeps it from being complete, one clause each.
  [[nodiscard]] std::vector<std::string> shortfalls() const;
  /// How long nothing had come from a LiDAR when the capture was ended.
  [[nodiscard]] std::int64_t silence_ns(const CaptureDevice& device) const;
};

/// Records the LiDARs and cameras of a rig into a session until it is told to stop, its time is over or its stops are
/// in; looks out for them, turns a table that turns itself, tells `show` twice a second how they do, and writes into
/// session.json what happened. Trouble of a sensor or of the network ends nothing, nor do images of a camera that
/// cannot be written: the status of the camera says so. Errors: the session exists already; no LiDAR in the rig; no
/// interface, a port that is taken; a table that cannot be had; the disk (the session is closed then, and holds what
/// was written).
[[nodiscard]] Expected<CaptureSummary> capture(const Rig& rig, const livox::DriverOptions& driver,
                                               const CaptureOptions& options, const RunContext& context,
                                               const std::function<void(const CaptureStatus&)>& show);

}  // namespace rigcal
