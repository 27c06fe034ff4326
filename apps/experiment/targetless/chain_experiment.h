#pragma once

#include <string>
#include <vector>

#include "apps/experiment/targetless/lidar_experiments.h"

namespace rigcal::targetless {

/// Fig. 9: how far the outer units of a MID-100 are off from the middle one, by one method on one rig in one scene.
struct ChainRow {
  std::string rig;  ///< "MID-100": alone, the middle unit the base; "AVIA": that is the base, the units are chained.
  std::string scene;
  std::string method;
  int pairs = 0;  ///< Of units, over all trials,
  int found = 0;  ///< and those with an answer.
  MeanSpread rotation_rad;
  MeanSpread translation_m;
};

/// The MID-100 alone in four scenes and with the AVIA in two, each from guesses of 10 degrees and 0.2 m: ours, by ICP,
/// and by motion, which has no guess and a run of its own along a figure of eight. Errors: cancelled.
[[nodiscard]] Expected<std::vector<ChainRow>> try_chain(const LidarExperimentOptions& options,
                                                        const RunContext& context);

}  // namespace rigcal::targetless
