#include "simdata/live/live_stamp.h"

#include <cmath>
#include <cstring>

namespace rigcal::sim {
namespace {

// Offsets in a sample packet.
constexpr std::size_t stamp_at = 10;
constexpr std::size_t gyro_at = livox::kSampleHeaderBytes;

}  // namespace

std::int64_t LiveTime::stamp_ns(const DeviceClock& clock, std::int64_t rendered_ns) const {
  const auto since_zero =
      static_cast<double>(rendered_ns - clock.stamp_at_zero_ns) + earlier_s * (1.0 + clock.drift) * 1e9;
  return clock.stamp_at_zero_ns + std::llround(since_zero / speed) - boot_stamp_ns;
}

std::int64_t rendered_stamp_ns(std::span<const std::uint8_t> packet) {
  std::int64_t stamp = 0;
  std::memcpy(&stamp, packet.data() + stamp_at, sizeof stamp);
  return stamp;
}

void speed_up_gyro(double speed, std::span<std::uint8_t> packet) {
  if (speed == 1.0) return;
  float rates[3];
  std::memcpy(rates, packet.data() + gyro_at, sizeof rates);
  for (float& rate : rates) rate *= static_cast<float>(speed);
  std::memcpy(packet.data() + gyro_at, rates, sizeof rates);
}

}  // namespace rigcal::sim
