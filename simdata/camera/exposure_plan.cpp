#include "simdata/camera/exposure_plan.h"

#include <algorithm>

namespace rigcal::sim {

std::vector<ExposurePulse> plan_exposures(const std::vector<Rest>& rests, int per_stop, double longest_s) {
  constexpr double settling_s = 0.6;
  std::vector<ExposurePulse> pulses;
  for (std::size_t stop = 0; stop < rests.size(); ++stop) {
    const double length = rests[stop].end_s - rests[stop].start_s;
    const double begin = rests[stop].start_s + std::min(settling_s, 0.4 * length);
    const double room = rests[stop].end_s - longest_s - begin;
    if (room <= 0.0) continue;
    for (int i = 0; i < per_stop; ++i) pulses.push_back({static_cast<int>(stop), begin + room * (i + 0.5) / per_stop});
  }
  return pulses;
}

}  // namespace rigcal::sim
