#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/board/board_model.h"
#include "core/board/rectangle_fit.h"
#include "core/records/records.h"

namespace rigcal {

/// Points nearer than this or farther are of no plate.
inline constexpr double nearest_plate_m = 0.4;
inline constexpr double farthest_plate_m = 10.0;

/// A place on a plate's border as a LiDAR saw it: between the last ray on it and the next one.
struct BorderPoint {
  Vector3d p = Vector3d::Zero();  ///< In the LiDAR's frame, on the plate's plane.
  int axis = 0;                   ///< The edge it lies on: 0 at +-x of the board, 1 at +-y.
  int sign = 1;
  double sigma_m = 0.01;
};

/// What the reflectivity of the squares told.
struct SquareCue {
  double contrast = 0.0;        ///< Difference of the two colours over their spread.
  bool first_is_dark = false;   ///< The squares with the colour of the first one (BoardModel::colour_at) are dark.
  double dark_farther_m = 0.0;  ///< By how much dark squares seem farther away than bright ones, along the rays.
  /// The board's pose by the directions in which its squares are seen: as far away as these have their true size, with
  /// the tilt of the plate. No range tells in it but in the tilt.
  SE3 T_lidar_pattern;
  double shift_sigma_m = 0.002;  ///< Across the ray, along either axis of the board,
  double angle_sigma_rad = 0.01;
  double scale_sigma = 0.1;  ///< and of the distance, as a share of it.
};

/// A plate in one cloud.
struct CloudBoard {
  SE3 T_lidar_board;             ///< But for the plate's turns.
  std::vector<Vector3d> points;  ///< On the plate, in the LiDAR's frame.
  std::vector<BorderPoint> border;
  double plane_rms_m = 0.0;
  double border_rms_m = 0.0;
  Eigen::Vector2d growth_m =
      Eigen::Vector2d::Zero();       ///< Of the seen edges against the rig file's size, see RectangleFit.
  double overlap = 0.0;              ///< Area seen over the plate's.
  std::optional<SquareCue> squares;  ///< Where the squares are seen: then the pose is by these, too.
  int rings = 0;                     ///< That crossed it; 0: the LiDAR has none.
};

/// The same plate with another of its turns (BoardModel::plate_turns) as its pose.
void take_turn(CloudBoard& found, const SE3& turn);

struct CloudBoards {
  std::vector<CloudBoard> boards;
  std::string why_none;  ///< In words, where there is none.
};

/// Finds plates in a cloud of a spinning LiDAR: segments of its rings, clusters of them, planes in these, the template
/// of the board laid on each by ICP, the rectangle fitted to the rings' ends. `rings_in_shot`: the points carry their
/// ring in Point::shot; otherwise rings are told by elevation.
[[nodiscard]] CloudBoards find_ring_boards(std::span<const Point> points, const BoardModel& board, bool rings_in_shot,
                                           std::uint64_t seed = 1);

/// Finds plates in a cloud without rings, as Livox sensors accumulate it over a stop: flat pieces of the right extent
/// that stand free, their outline by the density of the points, and the squares by their reflectivity where it shows
/// them.
[[nodiscard]] CloudBoards find_dense_boards(std::span<const Point> points, const BoardModel& board);

/// The one or the other, by whether the cloud has rings: by elevation, or, where `rings_in_shot`, by their numbers.
[[nodiscard]] CloudBoards find_cloud_boards(std::span<const Point> points, const BoardModel& board, bool rings_in_shot,
                                            std::uint64_t seed = 1);

}  // namespace rigcal
