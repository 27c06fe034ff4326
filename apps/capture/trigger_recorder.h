#pragma once

#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "apps/cameras/camera_recorder.h"
#include "apps/cameras/capture_event.h"
#include "core/base/heartbeat.h"
#include "core/io/frame_files.h"
#include "core/rig/rig.h"
#include "drivers/trigger/trigger.h"

namespace rigcal {

/// What the trigger lines of a rig are to do during a capture. Pulses come as often as the slowest camera that waits
/// for them is to send images (`frame_rate`), twice a second where none says; none before somebody lets them. Nothing
/// where the rig has no lines.
[[nodiscard]] std::optional<trigger::TriggerOptions> trigger_options(const Rig& rig);

/// The rig's trigger line during a capture: gives pulses, writes trigger.csv, and tells the cameras of each edge.
class TriggerRecorder {
 public:
  /// Starts at once; the cameras must outlive this. Errors: lines that cannot be had, the disk.
  [[nodiscard]] static Expected<std::unique_ptr<TriggerRecorder>> start(const trigger::TriggerOptions& options,
                                                                        const std::string& session,
                                                                        const net::ClockReading& session_start,
                                                                        std::vector<CameraRecorder*> cameras);
  /// As `finish`.
  ~TriggerRecorder();
  TriggerRecorder(const TriggerRecorder&) = delete;
  TriggerRecorder& operator=(const TriggerRecorder&) = delete;

  /// Whether pulses are given; from the start they are not.
  void hold(bool is_held) { trigger_->hold(is_held); }
  /// No more pulses; returns when all that were given are written and told.
  void finish();

  [[nodiscard]] trigger::TriggerReport report() const { return trigger_->report(); }
  /// Since the last call.
  [[nodiscard]] std::vector<CaptureEvent> take_events();
  /// What went wrong with the disk.
  [[nodiscard]] std::optional<Error> failure() const;
  /// Of the thread that writes down what comes, and those of the lines.
  [[nodiscard]] std::vector<const Heartbeat*> heartbeats() const;

 private:
  TriggerRecorder(std::unique_ptr<trigger::Trigger> trigger, TriggerTable table, std::vector<CameraRecorder*> cameras);
  void take();
  void note(const trigger::TriggerEvent& event);

  std::unique_ptr<trigger::Trigger> trigger_;
  TriggerTable table_;
  std::vector<CameraRecorder*> cameras_;
  Heartbeat heartbeat_{"pulses"};
  std::atomic<bool> is_stopped_{false};
  mutable std::mutex mutex_;  ///< Of what follows.
  std::vector<CaptureEvent> events_;
  std::optional<Error> failure_;
  std::thread thread_;
};

}  // namespace rigcal
