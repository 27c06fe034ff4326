#pragma once

#include <cstdint>
#include <vector>

#include "core/rig/rig.h"
#include "simdata/rig/turntable_motion.h"

namespace rigcal::sim {

/// One pulse of the trigger, in a stop that has settled.
struct ExposurePulse {
  int stop = 0;  ///< Index in the truth: a stop in which the rig was bumped is two.
  double time_s = 0.0;
};

/// `per_stop` pulses in each stop, evenly spread over the time after the rig has settled (0.6 s, at most 40 % of the
/// stop) in which exposures of `longest_s` (with their delays) still end within the stop. Stops too short for one have
/// none.
[[nodiscard]] std::vector<ExposurePulse> plan_exposures(const std::vector<Rest>& rests, int per_stop, double longest_s);

}  // namespace rigcal::sim
