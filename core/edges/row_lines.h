#pragma once

#include <span>
#include <vector>

#include "core/edges/row_steps.h"
#include "core/edges/step_lines.h"

namespace rigcal {

struct RowLineOptions {
  double reach = 0.028;              ///< A line begins with steps so near to each other, in u and v: 1.6 degrees.
  int least_rows = 5;                ///< It crosses so many,
  double min_filled = 0.6;           ///< of those that lie between its ends this share,
  double min_length = 0.010;         ///< and is so long, in u and v.
  int most_missed = 3;               ///< It ends where so many rows in turn have no step on it.
  double across_spacings = 0.65;     ///< Steps so near to a line belong to it.
  double max_rms = 0.45;             ///< Of their distances across, in spacings.
  double same_depth_m = 0.3;         ///< Steps of one line begin within this in depth,
  double same_depth_per_m = 0.03;    ///< and so much for each metre;
  double painted_depth_per_m = 0.3;  ///< painted ones lie on a road that goes away.
};

/// The straight rows of like steps of one face that cross several rows of a scan: poles, trunks, corners of vehicles
/// and houses, lanes and crossings. Those with most rows first. No step is in two of them. What runs along the rows of
/// the scan is not found.
[[nodiscard]] std::vector<StepLine> find_row_lines(std::span<const RowStep> steps, const RowLineOptions& options);

}  // namespace rigcal
