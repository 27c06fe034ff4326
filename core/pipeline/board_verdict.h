#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/board/board_halves.h"
#include "core/quality/lidar_quality.h"
#include "core/quality/result.h"
#include "core/quality/verdict.h"

namespace rigcal {

/// What the boards say of a camera's given focal length, where it is left to them.
struct FocalDoubt {
  double off = 0.0;    ///< By such a share it is too long,
  double sigma = 0.0;  ///< with this sigma; 0: not known.
  double moves_m = 0.0;
  double moves_rad = 0.0;  ///< By so much the camera's place depends on it.
};

/// What speaks for or against the place of one sensor that boards hold.
struct BoardEvidence {
  std::string name;
  std::string via;                  ///< The sensor that it shares most boards with,
  int shared = 0;                   ///< at so many stops,
  int agreeing = 0;                 ///< at so many of which the boards agree.
  std::vector<int> lost;            ///< Of the others those, by number, at which its board goes with no other sensor's,
  bool lost_together = false;       ///< and whether these are three or more on end.
  double runner_up = 0.0;           ///< Score of the best other place over this one's.
  bool via_failed = false;          ///< What is wrong with that sensor's place is wrong with this one's.
  std::optional<int> via_agreeing;  ///< And of its own boards, where it is not the base.
  bool several_boards = false;
  Matrix6d covariance = Matrix6d::Zero();
  bool observable = true;
  bool converged = true;
  FocalDoubt focal;
  BoardHalves halves;     ///< With the number of its stop.
  double hold_out = 0.0;  ///< Residuals of boards that were left out, over their noise; 0: too few boards.
};

[[nodiscard]] Verdict judge_by_boards(const BoardEvidence& evidence, const Requirement& require,
                                      const std::string& advice);

/// Which poses of the board would tell most that the ones shown do not: in words, empty where they are varied enough.
/// The first of these that is lacking, as the sensor sees it: normals that differ by 8 degrees (root mean square) about
/// both axes, boards more than 12 degrees to its left and to its right, the farthest 1.3 times as far as the nearest,
/// ten boards.
[[nodiscard]] std::string advice_on_poses(const BoardAdjustment& found, std::size_t sensor);

/// The offset of a LiDAR's ranges where it stands out: at least 8 mm and three of its sigmas.
[[nodiscard]] std::optional<RangeOffset> remarkable_offset(const BoardAdjustment& found, std::size_t sensor);

/// What the boards tell of the rig file's figures and of the LiDARs: a plate of another size, squares of another size,
/// ranges that are off. Sentences for the user.
[[nodiscard]] std::vector<std::string> findings_of(const BoardAdjustment& found, const BoardModel& board);

/// Why the rig file's inner_corners are in doubt: no image shows the whole board, and half of the parts that are seen,
/// three or more, have equally many corners along each side. Empty where they are in none; markers leave no doubt.
[[nodiscard]] std::string doubt_of_corners(const std::vector<BoardSighting>& sightings, const BoardModel& board);

/// How many times longer the ways between boards are by the LiDARs than by the cameras, where both saw three boards or
/// more that lie apart; 0: not known. Other than 1: the squares have another size than the rig file says.
[[nodiscard]] double scale_between(const std::vector<BoardSighting>& sightings);

}  // namespace rigcal
