#pragma once

#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <vector>

#include "core/pipeline/incremental_calibration.h"

namespace rigcal {

/// What is known after a stop in one line: each LiDAR with its 95 % bounds.
[[nodiscard]] std::string estimate_line(const StopEstimate& estimate);
/// The lines that follow it for who has to do something: which stops were left out, what is weak,
/// and the advice.
[[nodiscard]] std::vector<std::string> estimate_remarks(const StopEstimate& estimate);
/// The same for a terminal of 80 columns.
[[nodiscard]] std::vector<std::string> estimate_block(const StopEstimate& estimate);
/// All that is known after each stop, as the JSON array `estimates` of docs/schema/calibrate.json.
[[nodiscard]] nlohmann::ordered_json estimates_json(std::span<const StopEstimate> estimates);

}  // namespace rigcal
