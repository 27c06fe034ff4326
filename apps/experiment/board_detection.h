#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/base/run_context.h"

namespace rigcal {

/// What became of the boards in one scene before one kind of sensor.
struct DetectionRow {
  std::string scene;
  std::string sensor;
  int boards = 0;      ///< Shown, one a pose.
  int right = 0;       ///< Found on the plate's place: their common area is 0.95 of what either covers, or more.
  int wrong = 0;       ///< Found, but not there.
  int wrong_used = 0;  ///< Of these, those that a calibration by all poses of the scene would use.
};

/// Shows the paper's board `poses` times in all, in turn in a room, a courtyard and a field, free-standing before a
/// LiDAR of 16 rings and a camera with the paper's noise at k = 1. Errors: cancelled.
[[nodiscard]] Expected<std::vector<DetectionRow>> detect_boards(int poses, std::uint64_t seed,
                                                                const RunContext& context);

}  // namespace rigcal
