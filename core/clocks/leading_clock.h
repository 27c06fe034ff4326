#pragma once

#include <cstdint>

namespace rigcal {

/// Session time of a recording that has no other stamps than those of its devices, in the order in which the packets
/// came: the clock of the device that speaks first. Packets of the others came when its last one did. It never steps:
/// where the leading clock is set, starts again or leaves a gap, the recording's frames (a coarse count of time) carry
/// the time over; where the device falls silent, the next one that speaks leads on.
class LeadingClock {
 public:
  /// `frame_ns`: what a frame lasts.
  explicit LeadingClock(std::int64_t frame_ns) : frame_ns_(frame_ns) {}

  /// When a packet came, session time. `restarts_each_second`: the stamps count from a pulse (see PulseTime). Any
  /// values are safe.
  std::int64_t add(int device, std::int64_t device_ns, bool restarts_each_second, std::uint64_t frame);
  /// When the last packet came.
  [[nodiscard]] std::int64_t now_ns() const { return now_ns_; }

 private:
  std::int64_t frame_ns_;
  bool started_ = false;
  int leader_ = 0;
  std::int64_t last_device_ns_ = 0;  ///< Of the leader.
  std::uint64_t last_frame_ = 0;     ///< In which the leader spoke last.
  std::int64_t now_ns_ = 0;
};

}  // namespace rigcal
