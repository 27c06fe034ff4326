#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "apps/experiment/targetless/lidar_experiments.h"

namespace rigcal::targetless {

/// One iteration of one stage of one method: partners looked for (ours: the map of adaptive voxels built anew), then
/// all free poses moved.
struct StageSeconds {
  std::string method;
  std::string stage;  ///< "pose" (those of the base alone), "extrinsic" (poses held), "global".
  double match_s = 0.0;
  double solve_s = 0.0;
  std::size_t matched = 0;  ///< Ours: observations of planes; ICP: pairs of points.
};

/// Table I: what an iteration takes on all threads, medians of a few.
struct TimeExperiment {
  std::size_t points = 0;
  int patches = 0;
  double ours_prepare_s = 0.0;  ///< Points to cells, once.
  double icp_prepare_s = 0.0;   ///< Points thinned, normals and trees, once.
  std::vector<StageSeconds> stages;
};

/// In the courtyard, from poses and extrinsics off by 5 mm and 0.03 degrees. Errors: cancelled.
[[nodiscard]] Expected<TimeExperiment> measure_times(const LidarExperimentOptions& options, const RunContext& context);

}  // namespace rigcal::targetless
