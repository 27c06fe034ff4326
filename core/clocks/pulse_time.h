#pragma once

#include <cstdint>
#include <optional>

namespace rigcal {

/// Time since the first pulse, from stamps that start again at every pulse (one a second). Which second it is comes
/// from the receive stamps; they may be late by up to half a second, and pulses may be missed.
class PulseTime {
 public:
  /// Both in nanoseconds. Any values are safe: what was received absurdly far from the one before is told as it came.
  /// Where two in turn were, and near each other, the count goes on from these.
  [[nodiscard]] std::int64_t add(std::int64_t since_pulse_ns, std::int64_t received_ns);

 private:
  struct Stamp {
    std::int64_t ns = 0;
    std::int64_t received_ns = 0;
  };
  static std::optional<std::int64_t> following(const Stamp& last, std::int64_t since_pulse_ns,
                                               std::int64_t received_ns);

  std::optional<Stamp> last_;
  std::optional<Stamp> doubtful_;  ///< The one that came last, where it was too far from `last_`.
};

}  // namespace rigcal
