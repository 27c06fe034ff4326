#pragma once

#include <optional>
#include <vector>

#include "core/pipeline/lidar_result.h"

namespace rigcal {

/// The LiDAR whose frame a calibration is solved in, whichever the user calls the base, so that every choice of it
/// leads to the same numbers: the one whose gyro told the turns, where it saw surfaces in at least half as many
/// directions as any other, else the one that saw most. The user's base where poses, turns that are no gyro's, or an
/// axis without turns about it are told in its frame, which a rough guess would spoil on the way to another; one
/// without a guess only where there is no guess at all.
[[nodiscard]] int solving_lidar(const StartInput& input, const std::vector<std::optional<GyroTurn>>& gyro_turns,
                                const std::vector<PatchSurfels>& patches);

/// How far the rig turned before each stop (rad), by the gyros that told it: turns back get the other sign than turns
/// forth. Those that no gyro of a LiDAR told stay as they are.
[[nodiscard]] std::vector<std::optional<double>> with_signs(std::vector<std::optional<double>> turned_rad,
                                                            const std::vector<std::optional<GyroTurn>>& gyro_turns);

/// What is known, with another LiDAR as the base: guesses by its guess; turns as its own gyro told them, else by its
/// guess, else only how far the rig turned.
[[nodiscard]] StartInput seen_from(int lidar, const StartInput& input,
                                   const std::vector<std::optional<GyroTurn>>& gyro_turns);

/// A solution that was found with `from` as the base, with `base` as the base. Its layout and priors stay as they were:
/// they belong to the solving.
void change_base(int from, int base, LidarSolution& solution);

/// The world becomes the base's frame at the first stop that is known: where that of the recording was left out it was
/// the frame of a pose that is in no result.
void begin_at_first_stop(LidarSolution& solution);

}  // namespace rigcal
