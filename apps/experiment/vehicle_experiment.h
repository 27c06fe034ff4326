#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/base/run_context.h"
#include "core/geometry/se3.h"

namespace rigcal {

/// How far one way to calibrate was off over the places, medians.
struct WayFigures {
  std::string way;
  int answers = 0;  ///< Places with an answer at all.
  double rotation_rad = 0.0;
  double translation_m = 0.0;
};

/// A pair of LiDARs of the simulated vehicle and what became of it by each way.
struct VehicleRow {
  std::string pair;
  int places = 0;
  std::vector<WayFigures> ways;
};

/// One moment of the vehicle for a picture: what the first two LiDARs saw, in the frame of the first, by a rough guess
/// and by what was found.
struct VehicleMoment {
  std::vector<Vector3d> first;
  std::vector<Vector3d> second;
  SE3 T_guess;
  SE3 T_found;
};

struct VehicleExperiment {
  std::vector<VehicleRow> rows;
  VehicleMoment moment;
};

/// A vehicle with three LiDARs of 16 beams at places of a simulated court, calibrated in the ways that the planes paper
/// compares: three common planes without refinement, refined by point to plane registration of all surfaces, by the
/// paper's cost, from the motion of each LiDAR (odometry and hand-eye over a short drive), and by `calibrate --method
/// planes`. Errors: cancelled.
[[nodiscard]] Expected<VehicleExperiment> drive_vehicle(int places, std::uint64_t seed, const RunContext& context);

}  // namespace rigcal
