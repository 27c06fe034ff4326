#pragma once

#include <optional>
#include <vector>

#include "core/pipeline/lidar_result.h"

namespace rigcal {

/// What the place of a LiDAR says of the rough poses and of the recording. Indices are of LiDARs.
struct PlaceFindings {
  double from_guess_rad = 0.0;  ///< From its own rough pose; 0 without one.
  double from_guess_m = 0.0;
  /// Whose rough pose it fulfils instead of its own, which nobody fulfils: units of one housing in the wrong order.
  std::optional<int> stands_at;
  bool guess_is_inverse = false;     ///< All LiDARs stand where the inverses of their rough poses have them.
  std::optional<int> same_place_as;  ///< Another LiDAR that stands just there, as none can: both saw the same.
};

/// Of each LiDAR that has a place, in the frame of `base`.
[[nodiscard]] std::vector<PlaceFindings> place_findings(const std::vector<std::optional<SE3>>& guess_T_base_sensor,
                                                        const LidarSolution& solution, int base);

}  // namespace rigcal
