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

struct RowStepOptions {
  double min_rise_m = 0.4;           ///< The far surface is so much farther,
  double min_rise_per_m = 0.05;      ///< and so much for each metre of range.
  double same_surface_m = 0.3;       ///< The near surface goes on to the other side within this.
  double neighbour_steps = 3.0;      ///< Returns so far apart, in steps of their row, have others missing between them:
  double gap_steps = 5.0;            ///< nothing came back there, if it is so far.
  double farthest_gap_m = 60.0;      ///< Beyond, surfaces hardly give returns anyway.
  int painted_returns = 2;           ///< Reflectivities are means of so many on either side,
  double painted_contrast = 1.5;     ///< their difference over the root of their sum, which is how they scatter,
  double painted_even_m = 0.25;      ///< and ranges so even,
  double painted_even_per_m = 0.02;  ///< and so much less for each metre.
};

/// The steps of all rows on each face, in the order of the rows, of which the lowest is the first.
[[nodiscard]] std::array<std::vector<RowStep>, cube_faces> find_row_steps(std::span<const ScanRow> rows,
                                                                          const RowStepOptions& options);

}  // namespace rigcal
