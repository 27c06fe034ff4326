#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/board/board_model.h"
#include "core/edges/grey_image.h"
#include "core/rig/camera_model.h"

namespace rigcal {

/// A checkerboard in an image: its inner corners with their places, right-handed (the columns' direction crossed with
/// the rows' points away from the camera). Of boards that look the same after a turn, or of which a part is seen, the
/// corners may be others: see `alternatives`.
struct ImageBoard {
  std::vector<int> ids;                 ///< Of BoardModel::corner.
  std::vector<Eigen::Vector2d> pixels;  ///< Sub-pixel places of the corners.
  bool whole = true;                    ///< All inner corners are seen.
  /// The true pose is the one found with `ids` times one of these motions of the board; of whole boards the first is
  /// the identity.
  std::vector<SE3> alternatives;
};

struct ImageBoards {
  std::vector<ImageBoard> boards;
  std::string why_none;  ///< In words, where there is none.
};

/// Finds checkerboards by OpenCV's sector-based detector, corners by the saddle points of the grey values: whole ones,
/// up to `most`, and where there is no whole one the largest part of one, of at least 3 by 3 corners. Boards with
/// markers by find_charuco_board.
[[nodiscard]] ImageBoards find_image_boards(const GreyImage& grey, const BoardModel& board, int most = 4);

/// Pose of a board by its corners: the planar problem on rays, then least squares in pixels.
struct ImagePose {
  SE3 T_camera_board;
  double rms_px = 0.0;  ///< Root mean square length of the residuals.
};
/// Nothing for fewer than four corners that the camera's model has rays for, or where all lie on a line.
[[nodiscard]] std::optional<ImagePose> find_image_pose(const ImageBoard& seen, const BoardModel& board,
                                                       const CameraModel& camera);

/// Intrinsics of a camera from whole boards alone: a start for what refines them. Distortion begins at zero. Nothing
/// for fewer than three images (parts of boards with markers will do), or boards that all face the same way.
[[nodiscard]] std::optional<CameraIntrinsics> rough_intrinsics(const std::vector<ImageBoard>& seen,
                                                               const BoardModel& board, DistortionModel model,
                                                               int width, int height);

}  // namespace rigcal
