#include "apps/capture/capture_rates.h"

#include <utility>

namespace rigcal {

void CaptureRates::add(CaptureStatus& status, SteadyClock::time_point now) {
  const double since = seconds_between(std::exchange(last_, now), now);
  if (!(since > 0.0)) return;
  packets_.resize(status.devices.size(), 0);
  for (std::size_t i = 0; i < status.devices.size(); ++i) {
    const std::uint64_t packets = status.devices[i].report.packets;
    status.devices[i].packets_per_s = static_cast<double>(packets - std::exchange(packets_[i], packets)) / since;
  }
  frames_.resize(status.cameras.size(), 0);
  for (std::size_t i = 0; i < status.cameras.size(); ++i) {
    const std::uint64_t frames = status.cameras[i].counters.whole();
    status.cameras[i].frames_per_s = static_cast<double>(frames - std::exchange(frames_[i], frames)) / since;
  }
}

}  // namespace rigcal
