#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "core/board/board_sightings.h"

namespace rigcal {

/// One sensor in the joint adjustment.
struct BoardSensor {
  std::string name;
  SE3 T_base_sensor;
  bool fixed = false;                                  ///< The base.
  std::optional<CameraIntrinsics> camera;              ///< Of a camera; a LiDAR has none.
  double range_offset_m = 0.0;                         ///< To be added to a LiDAR's ranges,
  Eigen::Vector2d growth_m = Eigen::Vector2d::Zero();  ///< and by how much its beam widens the plate at each edge
  double usual_range_m = 0.0;                          ///< at this distance (mean over its borders; 0: not set yet),
  double widening = 0.0;                               ///< and for each metre farther.
  double sigma_px = 0.1;                               ///< Of a corner; estimated.
  double sigma_plane_m = 0.015;                        ///< Of a point across the plate,
  double sigma_border_m = 0.01;                        ///< and of a place on its border; estimated.
};

/// One board at one stop: the sightings of it, of each sensor at most one, with their turns resolved.
struct BoardPlace {
  int stop = 0;
  SE3 T_base_board;
  std::vector<BoardSighting> sightings;
  std::string why_out;  ///< Not empty: left out of the adjustment, and why.
};

/// Puts together what sensors that are placed saw of one board at one stop: of each sensor the sighting that lies where
/// the most certain one has the board, with the turn under which it does. Sightings that lie nowhere near another stay
/// alone. `sensors` without a place are asked nothing: `is_placed` has an entry for each; empty: all are.
[[nodiscard]] std::vector<BoardPlace> board_places(const std::vector<BoardSighting>& sightings,
                                                   const std::vector<BoardSensor>& sensors, const BoardModel& board,
                                                   const std::vector<char>& is_placed = {});

struct BoardAdjustOptions {
  bool refine_intrinsics = false;   ///< Of what boards do not tell they stay near those of the sensors.
  bool free_focal_lengths = false;  ///< Of given intrinsics these alone: a check.
  /// How far a LiDAR's ranges may be off; 0: not at all. Where the boards do not tell, the offset stays near zero.
  double range_offset_sigma_m = 0.03;
  double growth_sigma_m = 0.02;
  /// What no averaging over points takes away from a plate's plane: its own unevenness, the laser's calibration.
  double plane_floor_m = 0.001;
  /// The same for one of its edges: beams do not widen all of them alike.
  double border_floor_m = 0.002;
  int noise_passes = 3;        ///< The noise is estimated from the residuals so many times.
  bool sensors_fixed = false;  ///< Only the places of the boards are found.
  bool drop_outliers = true;
};

struct BoardAdjustment {
  std::vector<BoardSensor> sensors;
  std::vector<BoardPlace> places;
  /// Of each sensor's T_base_sensor, right perturbation; zero where fixed. Rotation and translation are each as wide as
  /// the boards differ, where that is more than the noise of what was seen of them has it.
  std::vector<Matrix6d> covariances;
  std::vector<double> range_offset_sigma_m;  ///< One for each sensor.
  std::vector<Eigen::Vector2d> growth_sigma_m;
  std::vector<double> focal_sigma;  ///< Of each camera's focal length along x, where it was free: a share of it.
  double cost_before = 0.0;
  double cost_after = 0.0;
  int iterations = 0;
  bool converged = false;
  std::vector<char> observable;  ///< One for each sensor: the boards hold its place, or it is fixed.
  double chi2 = 0.0;             ///< Residuals over their expected variance, a degree of freedom: 1 is right.
};

/// Adjusts all sensors and all boards at once (Ceres): corners in pixels, points across the plate, the plate's border,
/// each over its noise. Boards with fewer than two sightings hold nothing but intrinsics. A sighting whose residuals
/// are far above those of its sensor's others is left out, with its board where only one sighting is left.
[[nodiscard]] BoardAdjustment adjust_boards(std::vector<BoardSensor> sensors, std::vector<BoardPlace> places,
                                            const BoardModel& board, const BoardAdjustOptions& options);

/// Root mean square residuals of one sighting under an adjustment, over their noise (all kinds together) and in their
/// units.
struct SightingResiduals {
  double normalised = 0.0;
  double pixels = 0.0;  ///< Length of the corners' offsets.
  double plane_m = 0.0;
  double border_m = 0.0;
};
[[nodiscard]] SightingResiduals residuals_of(const BoardSighting& sighting, const BoardSensor& sensor,
                                             const SE3& T_base_board, const BoardModel& board);

}  // namespace rigcal
