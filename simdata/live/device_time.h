#pragma once

#include <cstdint>
#include <optional>

#include "drivers/livox_codec/sample_packet.h"

namespace rigcal::sim {

/// What a virtual device's clock is given to follow.
enum class TimeSource : std::uint8_t {
  none,  ///< Its own crystal.
  pps,   ///< A pulse a second; the host may tell the time of day (UTC) by command.
  ptp,   ///< A master of PTP in the network.
};

struct TimeSourceOptions {
  TimeSource source = TimeSource::none;
  std::int64_t pulse_ns = 0;       ///< When a pulse comes, on the clock of `now_ns`; the others come a second apart.
  std::int64_t utc_offset_ns = 0;  ///< From the clock of `now_ns` to the time of the PTP master.
};

/// How the device's stamps follow that. With pulses and a time of day the stamps are of type GPS; the time is believed
/// when it comes 10 to 500 ms after a pulse, and lasts for three seconds.
class DeviceTime {
 public:
  explicit DeviceTime(const TimeSourceOptions& options) : options_(options) {}

  /// The host says what time it was at the last pulse. False: there is a pulse, but the command came too soon after it
  /// or too late, or names a time that cannot be sent.
  bool set_utc(std::int64_t now_ns, std::int64_t unix_ns);
  /// The device starts anew.
  void restart();
  void tick(std::int64_t now_ns);
  /// When `tick` has something to do.
  [[nodiscard]] std::optional<std::int64_t> deadline_ns() const { return utc_end_ns_; }

  [[nodiscard]] livox::TimestampType type() const;
  /// The stamp of a sample taken at `time_ns`, for every type but `since_start`.
  [[nodiscard]] std::int64_t stamp_ns(std::int64_t time_ns) const;
  /// The status word with the bits of the time source as they are; unchanged without a source.
  [[nodiscard]] std::uint32_t with_sync_bits(std::uint32_t status) const;

 private:
  [[nodiscard]] std::int64_t since_pulse_ns(std::int64_t time_ns) const;

  TimeSourceOptions options_;
  std::int64_t utc_offset_ns_ = 0;          ///< As the host told.
  std::optional<std::int64_t> utc_end_ns_;  ///< Until then it is believed.
  bool utc_lapsed_ = false;
};

}  // namespace rigcal::sim
