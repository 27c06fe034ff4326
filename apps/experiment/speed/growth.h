#pragma once

#include <string>
#include <vector>

#include "apps/experiment/speed/stage_table.h"

namespace rigcal::speed {

/// One size of a run; seconds of processor, all threads together, which other work on the machine hardly changes.
/// Only what the row's series is named after differs within it; points grow with stops and LiDARs,
/// since each patch has as many.
struct GrowthRow {
  std::string by;  ///< "points", "stops", "LiDARs" or "voxels".
  double size = 0.0;
  double cells_s = 0.0;        ///< Points to cells.
  double map_s = 0.0;          ///< Cells to planes, merged ones too; by voxels the map alone.
  double iteration_s = 0.0;    ///< One joint iteration with the map anew; by voxels 0.
  double calibration_s = 0.0;  ///< Cells to verdict and all; by voxels 0.
  double memory_mb = 0.0;      ///< Beside the points; 0: not known.
};

struct GrowthOptions {
  double scale = 1.0;  ///< Of all numbers of points.
  std::uint64_t seed = 1;
  std::vector<double> points{5e5, 1e6, 2e6, 4e6, 8e6, 1.6e7};
  std::vector<int> stops{5, 10, 20, 40, 80};
  std::vector<int> lidars{2, 3, 4, 6, 8};
  /// Least sizes of the map's leaves; the cells are somewhat smaller.
  std::vector<double> leaves_m{2.0, 1.0, 0.5, 0.25, 0.125};
};

/// In the courtyard, by points, stops, LiDARs and voxels (leaves of the map, kept or not). Errors: the calibration's,
/// cancelled.
[[nodiscard]] Expected<std::vector<GrowthRow>> measure_growth(const GrowthOptions& options, const RunContext& context);

}  // namespace rigcal::speed
