#pragma once

#include <optional>
#include <vector>

#include "core/board/board_adjustment.h"

/// Other ways to place one sensor by boards that two saw, for comparison. Boards are places with a sighting of sensor 0
/// and one of sensor 1, with their turns resolved, as board_places gives them; the result is the motion from sensor 1's
/// frame to sensor 0's. Nothing where the boards do not determine it.
namespace rigcal {

/// The paper's own steps: planes, then the four corners of all plates.
[[nodiscard]] std::optional<SE3> place_as_published(const std::vector<BoardPlace>& boards, const BoardModel& board);
/// Its first half alone: rotation by normals, translation by planes.
[[nodiscard]] std::optional<SE3> place_by_planes(const std::vector<BoardPlace>& boards, const BoardModel& board);
/// Planes and the plate's four edges, each fitted to its own border points (after Zhou, Li and Kaess, IROS 2018):
/// sensor 0 is a LiDAR, sensor 1 a camera.
[[nodiscard]] std::optional<SE3> place_by_lines_and_planes(const std::vector<BoardPlace>& boards,
                                                           const BoardModel& board);
/// All inner corners in both images, pixels minimised by OpenCV's stereo calibration with the intrinsics held.
[[nodiscard]] std::optional<SE3> place_by_all_corners(const std::vector<BoardPlace>& boards, const BoardModel& board,
                                                      const CameraIntrinsics& camera_0,
                                                      const CameraIntrinsics& camera_1);

}  // namespace rigcal
