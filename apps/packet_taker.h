#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>

#include "apps/ingest_summary.h"
#include "apps/lidar_ingest.h"
#include "apps/packet_recorder.h"
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
    std::optional<Error> error;
  };
  /// For who reads the packets while they are recorded.
  [[nodiscard]] std::shared_ptr<RecordingProgress> progress() const { return progress_; }
  /// Also where an error ended it.
  [[nodiscard]] bool has_ended() const { return has_ended_; }
  [[nodiscard]] Figures figures() const;

 private:
  void run();
  void publish(std::optional<Error> error);

  livox::Driver& driver_;
  PacketRecorder recorder_;
  std::shared_ptr<RecordingProgress> progress_;
  LidarIngest ledger_;
  std::atomic<bool> has_ended_{false};
  mutable std::mutex mutex_;
  Figures figures_;
  std::thread thread_;
};

}  // namespace rigcal
