#pragma once

#include <span>
#include <vector>

#include "core/edges/row_steps.h"
#include "core/edges/step_lines.h"

namespace rigcal {

/// The straight rows of like steps of one face that cross several rows of a scan: poles, trunks, corners of vehicles
/// and houses, lanes and crossings. Those with most rows first. No step is in two of them. What runs along the rows of
/// the scan is not found.
[[nodiscard]] std::vector<StepLine> find_row_lines(std::span<const RowStep> steps);

}  // namespace rigcal
