#pragma once

#include <cstdint>

#include "core/clocks/offset_line.h"

namespace rigcal {

/// What is known of a device's clock.
struct ClockFigures {
  std::uint64_t packets = 0;
  std::uint64_t strays = 0;  ///< Packets whose stamps fit neither what came before nor what followed.
  std::uint64_t jumps = 0;   ///< Times the clock was set or the device started anew.
  double drift_ppm = 0.0;    ///< Positive: the device's clock runs fast. From the last ten seconds.
  double mean_delay_ns = 0.0;
  double jitter_ns = 0.0;  ///< Standard deviation of the delay of the packets.
  double max_delay_ns = 0.0;
};

/// A device stamp on the session clock.
struct SessionStamp {
  std::int64_t stamp_ns = 0;
  bool stray = false;   ///< The device stamp makes no sense here; `stamp_ns` is when the packet came.
  bool jumped = false;  ///< The mapping starts anew with this packet: gaps across it cannot be counted.
};

/// Maps the stamps of one device, whatever its clock follows (its own crystal, PTP, GPS, PPS), to session time, from
/// the pairs (device stamp, receive stamp). All streams of a device share one. The answer for a packet depends on it
/// and on the packets before it only. It is the true session time plus the shortest delay on the way, which nothing
/// can tell from an offset of the clocks.
///
/// The offset follows an OffsetLine without steps: at most 20 % of the time's own pace while it mends a start on
/// delayed packets (tens of milliseconds), parts per million afterwards; so stamps in order stay in order. Only a
/// jump steps: five packets in a row whose stamps lie 20 ms early, 1 s late, or before what came already, or an offset
/// that is found to be off by more than 100 ms.
class DeviceClock {
 public:
  /// `device_ns` must not restart at a pulse (see PulseTime). Any values are safe; damaged ones come back as strays.
  [[nodiscard]] SessionStamp add(std::int64_t device_ns, std::int64_t received_ns);

  [[nodiscard]] ClockFigures figures() const;

 private:
  /// The offset as it is used: `rate` up to `end`, the line's slope afterwards.
  struct Course {
    double start = 0.0;
    double offset = 0.0;
    double rate = 0.0;
    double end = 0.0;
    double slope = 0.0;
    [[nodiscard]] double at(double time) const;
  };

  void start(std::int64_t device_ns, std::int64_t received_ns);
  [[nodiscard]] bool is_stray(double time, double offset) const;
  [[nodiscard]] SessionStamp add_stray(double offset, std::int64_t device_ns, std::int64_t received_ns);
  bool mend_late_shift();
  bool steer();
  void count_delay(double delay);

  bool started_ = false;
  std::int64_t origin_device_ns_ = 0;
  std::int64_t origin_offset_ns_ = 0;
  OffsetLine line_;
  Course course_;
  double latest_ = 0.0;
  int strays_in_row_ = 0;
  double stray_offset_ = 0.0;
  ClockFigures figures_;
  double delay_sum_ = 0.0;
  double delay_square_sum_ = 0.0;
};

}  // namespace rigcal
