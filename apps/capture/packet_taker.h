#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include "apps/capture/packet_recorder.h"
#include "apps/ingest/ingest_summary.h"
#include "apps/ingest/lidar_ingest.h"
#include "core/base/heartbeat.h"
#include "core/base/seconds.h"
#include "core/rig/rig.h"
#include "drivers/livox/device/driver.h"

namespace rigcal {

/// Takes everything that the driver hands out to the disk, on a thread of its own: neither a slow terminal nor the rest
/// of the program holds it up.
class PacketTaker {
 public:
  PacketTaker(livox::Driver& driver, PacketRecorder recorder, const Rig& rig);
  /// Stops the driver.
  ~PacketTaker();
  PacketTaker(const PacketTaker&) = delete;
  PacketTaker& operator=(const PacketTaker&) = delete;

  /// Waits until what the driver still has is recorded; it must have been stopped.
  void finish();
  struct Figures {
    IngestSummary ingest;
    std::uint64_t bytes = 0;
    std::uint64_t recorded = 0;
    std::optional<std::int64_t> forgotten_until_ns;
    std::int64_t worst_wait_ns = 0;   ///< From the arrival of a packet until it was taken to the file's buffer.
    std::int64_t recent_wait_ns = 0;  ///< The same of the last second alone.
    std::int64_t worst_write_ns = 0;  ///< The longest that it took to write some hundred packets.
    std::optional<Error> error;
  };
  /// For who reads the packets while they are recorded.
  [[nodiscard]] std::shared_ptr<RecordingProgress> progress() const { return progress_; }
  /// Also where an error ended it.
  [[nodiscard]] bool has_ended() const { return has_ended_; }
  [[nodiscard]] Figures figures() const;
  [[nodiscard]] const Heartbeat& heartbeat() const { return heartbeat_; }

 private:
  void run();
  /// How many, and when that was done.
  std::pair<int, SteadyClock::time_point> take_some(Expected<void>& written, SteadyClock::time_point& handed_over);
  void publish(std::optional<Error> error);

  livox::Driver& driver_;
  net::SessionClock clock_;
  PacketRecorder recorder_;
  std::shared_ptr<RecordingProgress> progress_;
  LidarIngest ledger_;
  Heartbeat heartbeat_{"packets"};
  std::int64_t worst_wait_ns_ = 0;   ///< Of the thread.
  std::int64_t recent_wait_ns_ = 0;  ///< Since the last figures.
  std::int64_t worst_write_ns_ = 0;
  std::atomic<bool> has_ended_{false};
  mutable std::mutex mutex_;
  Figures figures_;
  std::thread thread_;
};

}  // namespace rigcal
