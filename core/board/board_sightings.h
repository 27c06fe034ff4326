#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/board/board_clouds.h"
#include "core/board/board_images.h"
#include "core/board/board_model.h"

namespace rigcal {

/// One board as one sensor saw it at one stop. `sensor` counts from 0 in the caller's order.
struct BoardSighting {
  int sensor = 0;
  int stop = 0;
  SE3 T_sensor_board;             ///< By this sensor alone; the true one is this times one of `alternatives`.
  std::vector<SE3> alternatives;  ///< Motions of the board; at least one.
  double corner_sigma_m = 0.01;   ///< How well the plate's corners are known by this sensor alone.
  std::optional<ImageBoard> image;
  std::optional<CloudBoard> cloud;
};

[[nodiscard]] BoardSighting image_sighting(int sensor, int stop, ImageBoard seen, const ImagePose& pose,
                                           const BoardModel& board, const CameraModel& camera);
[[nodiscard]] BoardSighting cloud_sighting(int sensor, int stop, CloudBoard seen, const BoardModel& board);

/// A sighting with one of its alternatives taken: the pose is the true one, corner numbers follow.
[[nodiscard]] BoardSighting resolved(const BoardSighting& sighting, std::size_t alternative, const BoardModel& board);

/// How far this sighting's board may lie from where others see it: beyond that it is another board, or a wrong one.
[[nodiscard]] double agreement_gate(const BoardSighting& sighting, const BoardModel& board);

/// Where one sensor sits in the frame of another, by the boards that both saw.
struct PairPlacementByBoards {
  SE3 T_a_b;
  int agreeing = 0;        ///< Stops at which a board of both lies on one place under T_a_b,
  int shared = 0;          ///< of so many at which both saw any.
  double runner_up = 0.0;  ///< Score of the best other motion that no guess rules out over this one's, 0 .. 1.
};

/// Tries the motion that each pair of sightings of one stop, in each of their turns, would mean, and takes the one
/// under which most stops agree; then the closed form over these. So turned boards, several boards at once, parts of
/// boards and wrong sightings are told apart together. `guess` chooses between motions that explain the boards equally
/// well. Nothing where no stop has both.
[[nodiscard]] std::optional<PairPlacementByBoards> place_pair(const std::vector<BoardSighting>& sightings, int a, int b,
                                                              const BoardModel& board,
                                                              const std::optional<SE3>& guess_T_a_b);

}  // namespace rigcal
