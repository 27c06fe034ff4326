#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/base/run_context.h"

namespace rigcal {

struct BaseExperimentOptions {
  int rigs = 6;
  std::uint64_t seed = 1;
  int points = 20000;      ///< Of a patch.
  bool with_guess = true;  ///< 10 degrees and 0.2 m off.
  bool with_gyro = true;   ///< The first LiDAR's.
};

/// One rig, calibrated with each of its LiDARs as the base: how far the pose of any LiDAR in the frame of any other is
/// from that of the first calibration.
struct BaseRow {
  std::uint64_t seed = 0;
  std::string scene;
  int stops = 0;
  int lidars = 0;
  int failed = 0;  ///< LiDARs that one of the calibrations did not solve.
  double worst_mm = 0.0;
  double worst_deg = 0.0;
  double good_worst_mm = 0.0;  ///< Between LiDARs that both calibrations call good.
  double good_worst_deg = 0.0;
};

/// Rigs as they are built (an AVIA and three MID-40), in the three scenes. Errors: cancelled.
[[nodiscard]] Expected<std::vector<BaseRow>> try_bases(const BaseExperimentOptions& options, const RunContext& context);

[[nodiscard]] std::string base_experiment_text(const std::vector<BaseRow>& rows);
[[nodiscard]] std::string base_experiment_json(const std::vector<BaseRow>& rows);

}  // namespace rigcal
