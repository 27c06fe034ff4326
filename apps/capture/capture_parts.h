#pragma once

#include <memory>
#include <string>
#include <vector>

#include "apps/cameras/camera_recorder.h"
#include "apps/capture/capture.h"
#include "apps/capture/disk_wait.h"
#include "apps/capture/live_stops.h"
#include "apps/capture/packet_taker.h"
#include "apps/capture/session_keeper.h"
#include "apps/capture/table_recorder.h"
#include "apps/capture/trigger_recorder.h"

namespace rigcal {

/// What a capture owns, in the order in which it is started; it is let go in the opposite order, also where one of them
/// cannot be started.
struct CaptureParts {
  std::unique_ptr<livox::Driver> driver;
  std::unique_ptr<TableRecorder> table;  ///< Nothing where it is turned by hand.
  std::unique_ptr<PacketTaker> recording;
  std::vector<std::shared_ptr<CameraRecorder>> cameras;
  std::unique_ptr<TriggerRecorder> trigger;  ///< Nothing where the rig has no lines, or where they cannot be had:
  std::string no_trigger;                    ///< why.
  std::unique_ptr<StopSink> no_points;       ///< Where nobody wants those of the stops.
  std::unique_ptr<LiveStops> stops;
  std::unique_ptr<SessionKeeper> keeper;

  /// Makes the session and starts all of them. Errors: as of `capture`.
  [[nodiscard]] static Expected<CaptureParts> start(const Rig& rig, const livox::DriverOptions& driver,
                                                    const CaptureOptions& options, Reporter& reporter);
  /// No more pulses, then no more frames, then no more packets; then what is on its way is written. The stops can be
  /// read to their end after that, and session.json is the caller's.
  void finish_recording(const DiskPatience& patience);

  [[nodiscard]] std::vector<std::string> camera_names() const;
  [[nodiscard]] std::vector<const Heartbeat*> heartbeats() const;
};

}  // namespace rigcal
