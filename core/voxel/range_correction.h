#pragma once

#include "core/voxel/cells.h"

namespace rigcal {

/// What ranges are too long by: on what is white `white_m`, on what is black (Cell::darkness 1) by `black_m` more, and
/// by a share of it in between.
struct RangeError {
  double white_m = 0.0;
  double black_m = 0.0;

  [[nodiscard]] double at(double darkness) const { return white_m + black_m * darkness; }
  RangeError& operator+=(const RangeError& more) {
    white_m += more.white_m;
    black_m += more.black_m;
    return *this;
  }
};

/// The patch as a LiDAR sees it whose ranges have no such error: cells and thinned points move along their rays. Cubes
/// move as a point of the patch does in the mean.
void shorten_ranges(PatchCells& patch, const RangeError& error);

}  // namespace rigcal
