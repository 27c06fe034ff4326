#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "apps/experiment/speed/speed_set.h"

namespace rigcal::speed {

/// What one step of a calibration took on all threads.
struct StageSpeed {
  std::string stage;
  double seconds = 0.0;
  double cpu_s = 0.0;  ///< Of all threads; 0: not measured.
  /// What it cannot do without: its input read once and its output written once (each map of a stage that builds
  /// several). 0: not counted.
  double bytes = 0.0;
};

/// The steps of a calibration of one run, from packets to the verdict. `packets` to `one iteration` are single steps,
/// medians of three; the others are the stages of a whole calibration, as `report.json` has them.
struct StageTable {
  std::uint64_t points = 0;
  int lidars = 0;
  int stops = 0;
  std::size_t cells = 0;         ///< Cubes and pieces.
  std::size_t pieces = 0;        ///< Of these.
  std::size_t planes = 0;        ///< Leaves of the map and merged ones.
  std::size_t observations = 0;  ///< Pairs of a plane and a patch that sees it.
  std::vector<StageSpeed> stages;
  double calibration_cpu_s = 0.0;  ///< Of all threads, as `calibration_s`.
  double worst_m = 0.0;            ///< The worst LiDAR's distance from the truth after the calibration.
  double memory_mb = 0.0;          ///< What cells and calibration took at most beside the points; 0: not known.

  /// 0: there is no such stage.
  [[nodiscard]] double seconds(const std::string& stage) const;
  [[nodiscard]] double cpu_s(const std::string& stage) const;
  /// From points to extrinsics and verdict, without the map that is drawn: cells and all stages.
  [[nodiscard]] double calibration_s() const;
};

/// Errors: the calibration's.
[[nodiscard]] Expected<StageTable> time_stages(const SpeedSet& set, const RunContext& context);

}  // namespace rigcal::speed
