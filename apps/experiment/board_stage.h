#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/base/random.h"
#include "core/board/board_sightings.h"
#include "core/rig/rig.h"
#include "simdata/scene/scene.h"
#include "simdata/targets/board_views.h"

namespace rigcal {

/// One sensor of the checkerboard experiments: a camera, or a LiDAR of 16 rings.
struct BoardStation {
  std::string name;
  SE3 T_rig_sensor;  ///< Rig frame: x forward, y left, z up.
  std::optional<CameraIntrinsics> camera;
};

/// The paper's board: 0.77 by 0.63 m, squares of 0.07 m to its edges.
[[nodiscard]] BoardSettings published_board();
/// The paper's camera: 1280 by 720 pixels, 90 degrees wide, no distortion.
[[nodiscard]] CameraIntrinsics published_camera();
/// Two LiDARs, then two cameras, side by side within half a metre and turned by some degrees, which `random` draws.
[[nodiscard]] std::vector<BoardStation> published_rig(Random& random);

/// Variance of the paper's noise: k times that of 15 mm and of 0.007 of the grey values' range.
struct ViewNoise {
  double range_m = 0.0;
  double grey = 0.0;  ///< Of 0 .. 1.
};
[[nodiscard]] ViewNoise published_noise(int k);

/// Where boards are shown, in the rig's frame.
struct PoseRange {
  double near_m = 1.9;
  double far_m = 3.3;
  double bearing_rad = to_rad(30.0);  ///< To both sides,
  double height_m = 0.25;             ///< up and down,
  double lean_rad = to_rad(35.0);     ///< to all sides,
  double turn_rad = to_rad(25.0);     ///< about 45 degrees in the plate's plane.
};
[[nodiscard]] SE3 draw_board_pose(const PoseRange& range, Random& random);
/// Whether the whole plate lies in the image of each camera, and `margin_px` from its borders.
[[nodiscard]] bool is_in_all_images(const std::vector<BoardStation>& stations, const SE3& T_rig_board,
                                    const BoardModel& board, double margin_px);

/// Where the rig stands.
struct BoardStage {
  sim::Scene scene;
  SE3 T_scene_rig;
  bool is_bare = false;  ///< Even walls all round: images are rendered near the board only, beside it they go on.
};
/// A bare hall of 14 by 10 by 4 m.
[[nodiscard]] BoardStage bare_hall();
/// Whether the ways to a plate a third larger than the board are free and nothing stands within 0.3 m behind it.
[[nodiscard]] bool stands_free(const BoardStage& stage, const std::vector<BoardStation>& stations,
                               const SE3& T_rig_board, const BoardModel& board);

/// What each station sees of a board: for each of `noises` a list with all their sightings (BoardSighting::sensor
/// counts stations), stop 0. LiDARs are asked as `calibrate` asks them, images as well.
[[nodiscard]] std::vector<std::vector<BoardSighting>> see_board(const BoardStage& stage,
                                                                const std::vector<BoardStation>& stations,
                                                                const SE3& T_rig_board, const BoardSettings& board,
                                                                const std::vector<ViewNoise>& noises,
                                                                std::uint64_t seed);

}  // namespace rigcal
