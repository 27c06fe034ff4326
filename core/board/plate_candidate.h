#pragma once

#include <optional>
#include <span>
#include <vector>

#include "core/board/board_clouds.h"
#include "core/corner/fitted_plane.h"

namespace rigcal {

/// A flat piece that may be the plate: its points, and where its outline was seen.
struct PlateCandidate {
  FittedPlane plane;             ///< Its normal towards the sensor.
  std::vector<Vector3d> points;  ///< In the LiDAR's frame.
  std::vector<Vector3d> outline;
  std::vector<Vector3d> outward;  ///< For each place of the outline the direction in which the plate ended there.
  double outline_sigma_m = 0.01;
  double area_m2 = 0.0;  ///< That it covers, where more is known of that than its hull; else 0.
};

/// Axes in a plane, so that a board with them looks away from the sensor: columns x, y and z = away.
[[nodiscard]] SE3 plane_frame(const FittedPlane& plane, const Vector3d& origin);

/// The plate in a candidate, or in words why it is none. The checks: the template's match error, the rectangle's fit,
/// and how much of the plate is covered.
struct PlateFit {
  std::optional<CloudBoard> board;
  std::string why_not;
  Eigen::Vector2d sides = Eigen::Vector2d::Zero();  ///< Of the smallest rectangle round the candidate, longer first.
};
[[nodiscard]] PlateFit fit_plate(const PlateCandidate& candidate, const BoardModel& board);

/// Why no candidate was taken, in words: the piece that comes nearest to the plate in size, and what it lacked.
[[nodiscard]] std::string why_no_plate(const std::vector<PlateFit>& fits, const BoardModel& board);

}  // namespace rigcal
