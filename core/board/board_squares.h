#pragma once

#include <span>

#include "core/board/board_clouds.h"

namespace rigcal {

/// Lays the pattern of the board on the reflectivity of a cloud's points near a plate that was found: of the places
/// within half a square and 3 degrees of the outline's, in each turn of the plate, the one at which the squares of the
/// two colours differ most (of equal ones that nearest to the outline's), and from there by least squares
/// (`fit_squares`). Where they differ clearly, `found` gets the turn and the place, the distance by the squares' size,
/// the colours' difference in range, and its points shifted to where bright squares lie. Otherwise it stays as it is.
void look_at_squares(std::span<const Point> points, const BoardModel& board, CloudBoard& found);

}  // namespace rigcal
