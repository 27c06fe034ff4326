#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "apps/recording/datagram_file.h"
#include "apps/replay/recorded_devices.h"
#include "core/base/run_context.h"

namespace rigcal {

/// A recording that is played: what its LiDARs sent, each with the time at which it is due, again and again where that
/// is asked for.
class ReplayReading {
 public:
  /// Reads the whole recording once, to know its devices. Errors: as reading it; nothing of a LiDAR in it.
  [[nodiscard]] static Expected<ReplayReading> open(const std::string& file, const RunContext& context);

  [[nodiscard]] const RecordedDevices& devices() const { return devices_; }
  [[nodiscard]] const std::string& truncation() const { return truncation_; }

  /// The stamp at which playing begins: that of the first datagram of a LiDAR, or of the first sample.
  [[nodiscard]] std::int64_t first_ns() const { return first_ns_; }
  [[nodiscard]] std::int64_t first_sample_ns() const { return devices_.first_sample_ns().value_or(first_ns_); }
  [[nodiscard]] std::int64_t last_ns() const { return devices_.last_ns(); }
  /// Datagrams of a pass that no LiDAR sent.
  [[nodiscard]] std::uint64_t left_out() const { return left_out_; }

  /// The next datagram of a LiDAR; false at the end of a pass. It lives until the next call.
  [[nodiscard]] Expected<bool> next(Datagram& datagram);
  /// To the beginning.
  Expected<void> rewind();

 private:
  ReplayReading() = default;
  Expected<bool> read(Datagram& datagram);

  std::string path_;
  RecordedDevices devices_;
  std::string truncation_;
  std::int64_t first_ns_ = 0;
  std::uint64_t left_out_ = 0;
  std::unique_ptr<DatagramFile> file_;
  RecordedDevices heard_;  ///< In this pass.
};

}  // namespace rigcal
