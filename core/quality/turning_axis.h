#pragma once

#include <optional>
#include <vector>

#include "core/geometry/se3.h"

namespace rigcal {

/// The line that a rig turns about, in the world: it stands still while T_G_base changes.
struct TurningAxis {
  Vector3d direction = Vector3d::UnitZ();  ///< Unit.
  Vector3d point = Vector3d::Zero();       ///< Nearest to the world's origin.

  /// Turned about the line by `angle_rad`, right-handed.
  [[nodiscard]] SE3 turn(double angle_rad) const;
};

/// The line that fits the known poses best by least squares; nothing where none of them is turned by 3 degrees against
/// the first known one, which must be the identity. `about`: which of its two directions.
[[nodiscard]] std::optional<TurningAxis> find_turning_axis(const std::vector<SE3>& T_G_base,
                                                           const std::vector<char>& known, const Vector3d& about);

}  // namespace rigcal
