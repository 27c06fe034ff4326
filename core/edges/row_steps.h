#pragma once

#include <array>
#include <span>
#include <vector>

#include "core/edges/depth_steps.h"
#include "core/edges/scan_rows.h"

namespace rigcal {

/// What changes along a row from one return to the next, left to right or right to left.
enum class RowChange {
  ends_before_farther,  ///< A surface ends, and a farther one or nothing is seen past it, with growing azimuth
  begins,               ///< or falling azimuth.
  gets_brighter,        ///< The reflectivity of one surface changes: paint on a road.
  gets_darker
};

/// A place between two returns of a row, on a cube's face.
struct RowStep {
  double u = 0.0;
  double v = 0.0;
  double inverse_depth = 0.0;                          ///< Of the near surface, along the face's axis, 1/m.
  double spacing = 0.0;                                ///< Of the row's returns there, in u and v.
  Eigen::Vector2d towards = Eigen::Vector2d::UnitX();  ///< Unit: where what is farther, or brighter, lies.
  int row = 0;
  RowChange change = RowChange::begins;

  [[nodiscard]] bool is_painted() const {
    return change == RowChange::gets_brighter || change == RowChange::gets_darker;
  }
};

/// The steps of all rows on each face, in the order of the rows, of which the lowest is the first.
[[nodiscard]] std::array<std::vector<RowStep>, cube_faces> find_row_steps(std::span<const ScanRow> rows);

}  // namespace rigcal
