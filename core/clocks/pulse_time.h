#pragma once

#include <cstdint>

namespace rigcal {

/// Time since the first pulse, from stamps that start again at every pulse (one a second). Which second it is comes
/// from the receive stamps; they may be late by up to half a second, and pulses may be missed.
class PulseTime {
 public:
  /// Both in nanoseconds. Any values are safe.
  [[nodiscard]] std::int64_t add(std::int64_t since_pulse_ns, std::int64_t received_ns);

 private:
  bool started_ = false;
  std::int64_t last_ns_ = 0;
  std::int64_t last_received_ns_ = 0;
};

}  // namespace rigcal
