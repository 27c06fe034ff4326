#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/quality/lidar_quality.h"

namespace rigcal {

/// Bounds (95 %) beyond which a direction counts as open: nothing holds it.
constexpr double open_translation_m = 0.5;
constexpr double open_rotation_rad = 0.52;

/// What nothing holds of a LiDAR, in words.
struct OpenDirections {
  std::string what;     ///< "its place along z (up and down) of the base frame and its turn about ..."; empty: nothing.
  std::string surface;  ///< What would hold it: "a level surface (a floor, a ceiling, a table)".
};

[[nodiscard]] OpenDirections open_directions(const Matrix6d& covariance, const SE3& T_base_sensor);

/// The axes of the ellipsoids of place and turn that reach beyond `require`, and what would hold them. `frozen` (sensor
/// frame): the direction in which nothing was fitted; zero: there is none.
[[nodiscard]] std::vector<WeakDirection> weak_directions(const Matrix6d& covariance, const SE3& T_base_sensor,
                                                         const Requirement& require,
                                                         const Vector3d& frozen = Vector3d::Zero());

/// The surface that would hold the direction in which the LiDAR's place is known worst.
[[nodiscard]] std::string surface_for_weak_translation(const Matrix6d& covariance, const SE3& T_base_sensor);

/// A turn of the rig that would do in place of a new surface.
struct HelpfulTurn {
  double by_rad = 0.0;    ///< About the base's z from where it stood, -90 to 90 degrees.
  double seen_rad = 0.0;  ///< The widest turn between two of the stops so far.
};

/// The turn after which surfaces that were seen face the direction in which the LiDAR's place is known worst. Nothing
/// where that direction is not level, where no upright surface was seen, or where one faces that way already.
[[nodiscard]] std::optional<HelpfulTurn> turn_for_weak_translation(const SolvedPlanes& solved, int lidar,
                                                                   const Matrix6d& covariance);

/// ", or stops after a turn of about 90 degrees (so far the rig turned by 3 degrees only): ..."; empty without one.
[[nodiscard]] std::string turn_words(const std::optional<HelpfulTurn>& turn);

}  // namespace rigcal
