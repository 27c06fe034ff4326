#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/board/board_model.h"

namespace rigcal {

/// A point on a plate: where its ray meets the plane, in the board's frame, and its reflectivity.
struct SquareSpot {
  Eigen::Vector2d at;
  double reflectivity = 0.0;
};

/// How the pattern lies on the plane: a place q of the board is seen at shift + scale R(angle) q.
struct SquaresPlace {
  Eigen::Vector2d shift = Eigen::Vector2d::Zero();
  double angle_rad = 0.0;
  double scale = 1.0;  ///< Below one: the board is farther away than the plane it was laid on.
};

struct SquaresFit {
  SquaresPlace place;
  double shift_sigma_m = 0.0;  ///< Along either axis, by the points' scatter alone.
  double angle_sigma_rad = 0.0;
  double scale_sigma = 0.0;
  double blur_m = 0.0;  ///< Within which the reflectivity goes over from one colour to the other.
};

/// Least squares of the points' reflectivity against two values that go over into each other at the squares' lines
/// (Gauss-Newton, Huber's weights). A blur that is alike to both sides, as a beam's footprint is, moves no line, so the
/// squares' size is seen truly, which the plate's own outline does not show. `start` has to be within a quarter of a
/// square. Nothing where it does not settle near there, has too few points, or the colours do not differ.
[[nodiscard]] std::optional<SquaresFit> fit_squares(const std::vector<SquareSpot>& spots, const BoardModel& board,
                                                    const SquaresPlace& start);

}  // namespace rigcal
