#pragma once

#include <string>
#include <vector>

#include "apps/experiment/planes_experiment.h"
#include "apps/experiment/vehicle_experiment.h"

namespace rigcal {

/// All that `rigcal experiment planes` found.
struct PlanesExperiment {
  int trials = 0;
  std::vector<CornerRow> table;
  MountingFigures mountings;
  MountingFigures right_angles;          ///< Without a guess.
  MountingFigures right_angles_guessed;  ///< With one that is 45 degrees wrong.
  VehicleExperiment vehicle;
};

/// The tables for people.
[[nodiscard]] std::string planes_experiment_text(const PlanesExperiment& experiment);
/// One JSON object, docs/schema/experiment_planes.json.
[[nodiscard]] std::string planes_experiment_json(const PlanesExperiment& experiment);

/// A moment of the vehicle from above as an SVG file: what the first LiDAR saw, and the second laid on it by T_a_b.
[[nodiscard]] std::string moment_svg(const VehicleMoment& moment, const SE3& T_a_b, const std::string& title);

}  // namespace rigcal
