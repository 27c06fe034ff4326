#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "core/board/board_sightings.h"
#include "core/pipeline/camera_stage.h"

namespace rigcal {

/// What one sensor showed of the board.
struct SensorBoards {
  std::vector<BoardSighting> sightings;
  std::map<int, std::string> why_none;  ///< By stop (index into the recording's).
  std::map<int, std::string> why_part;  ///< Of stops at which a part of the board was found and is used.
  int views = 0;                        ///< Stops at which it saw anything at all.
  std::optional<CameraIntrinsics> camera;
  std::string why_not;  ///< Why nothing could be looked for, in words.
  std::vector<UsedImage> images;
};

/// Boards in all patches of one LiDAR, on all threads. `sensor` is its index in the rig; `seed` of the draws in clouds
/// with rings.
[[nodiscard]] SensorBoards find_lidar_boards(const Rig& rig, int sensor, const std::vector<Patch>& patches,
                                             const BoardModel& board, std::uint64_t seed, const RunContext& context);

/// Boards in all images of one camera, on all threads. Without intrinsics in the rig file they are guessed from whole
/// boards where `guess_intrinsics`.
[[nodiscard]] SensorBoards find_camera_boards(const Rig& rig, const CameraRecording& camera, const BoardModel& board,
                                              bool guess_intrinsics, const RunContext& context);

/// The reason that most stops have, and at how many: for a sentence.
[[nodiscard]] std::string commonest_reason(const std::map<int, std::string>& why, const std::vector<Stop>& stops);

}  // namespace rigcal
