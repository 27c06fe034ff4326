#pragma once

#include <memory>
#include <optional>
#include <stop_token>
#include <string>

#include "apps/recording/datagram_file.h"
#include "apps/recording/recording_progress.h"
#include "core/base/heartbeat.h"

namespace rigcal {

/// The packets of a session while they are recorded: reads behind the writer and waits for more until the writer has
/// ended. It sees exactly the datagrams that the finished session has, in their order, and those that were thrown away
/// since (--keep), unless it falls so far behind that they are gone. The writer never waits for it.
class GrowingDatagrams final : public DatagramFile {
 public:
  /// `stop` ends the waiting early; `heartbeat`, which may be null and must outlive this, beats while it waits.
  GrowingDatagrams(std::shared_ptr<RecordingProgress> progress, std::stop_token stop, Heartbeat* heartbeat = nullptr)
      : progress_(std::move(progress)), stop_(std::move(stop)), heartbeat_(heartbeat) {}

  /// Waits for the next datagram; false when the recording has ended or it was told to stop. Errors: the disk.
  [[nodiscard]] Expected<bool> next(Datagram& datagram) override;
  [[nodiscard]] std::string truncation() const override { return {}; }
  [[nodiscard]] FileNotes notes() const override;
  [[nodiscard]] double fraction() const override { return 0.0; }

 private:
  [[nodiscard]] bool await_growth() const;
  Expected<void> open_part();

  std::shared_ptr<RecordingProgress> progress_;
  std::stop_token stop_;
  Heartbeat* heartbeat_;
  std::optional<PcapReader> reader_;
  int part_ = 1;  ///< Of `reader_`, or the one to open next.
  PcapCounters earlier_;
};

}  // namespace rigcal
