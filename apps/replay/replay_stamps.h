#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/clocks/pulse_time.h"
#include "drivers/livox_codec/sample_packet.h"

namespace rigcal {

/// How recorded packets of a device become those of one that runs now. At the recorded pace and the first time through
/// they stay as they are, byte for byte.
struct ReplayPace {
  double speed = 1.0;           ///< So many times faster; the gyro turns faster with it.
  std::int64_t earlier_ns = 0;  ///< Recorded time of the passes before this one.
};

/// One device's packets, in the order in which it sent them.
class ReplayStamps {
 public:
  /// Makes `packet`, which came at `received_ns` in the recording, one of a device that runs at this pace. Anything
  /// that is no sample packet stays as it is.
  void rewrite(const ReplayPace& pace, std::int64_t received_ns, std::vector<std::uint8_t>& packet);

  /// The device has started anew: stamps that count from its start begin at this with its next packet.
  void restart(std::int64_t stamp_ns) { restart_stamp_ns_ = stamp_ns; }

 private:
  PulseTime pulse_;
  std::optional<std::int64_t> first_ns_;          ///< Recorded stamp of the first packet, without pulses.
  std::optional<std::int64_t> restart_stamp_ns_;  ///< To be taken by the next packet.
  std::int64_t started_ns_ = 0;                   ///< What stamps that count from the device's start are less by.
};

/// The same points in the other coordinates, where `spherical` says so; the records of a packet without a return stay
/// empty. The number of echoes stays.
void change_coordinates(bool spherical, std::vector<std::uint8_t>& packet);

}  // namespace rigcal
