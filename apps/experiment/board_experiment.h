#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/base/run_context.h"

namespace rigcal {

/// Medians over the draws in which one way to calibrate gave an answer.
struct BoardWay {
  std::string way;
  int answers = 0;
  double rotation_rad = 0.0;
  double translation_m = 0.0;
  double worst_rotation_rad = 0.0;  ///< 95 of 100 draws are better,
  double worst_translation_m = 0.0;
  /// How far the corners of all poses' plates land in the (second) camera from where they are; 0 for pairs of LiDARs.
  double projection_px = 0.0;
};

/// One kind of pair at one noise and one number of poses.
struct BoardRow {
  std::string pair;
  int k = 1;  ///< The noise's variance is k times the paper's.
  int poses = 10;
  int draws = 0;
  std::vector<BoardWay> ways;  ///< `rigcal` first.
};

/// What the paper claims at k = 1 for a kind of pair.
struct BoardClaim {
  std::string pair;
  double rotation_rad = 0.0;
  double translation_m = 0.0;
};
[[nodiscard]] const std::vector<BoardClaim>& published_claims();

struct BoardDrawOptions {
  int draws = 1000;  ///< At k = 1 with 10 poses; a twentieth elsewhere.
  int sets = 4;      ///< Of poses, each with noise of its own; draws take them in turn.
  int poses_of_set = 27;
  bool asked_only = false;  ///< k = 1 with 10 poses and nothing else.
  std::uint64_t seed = 1;
};

/// The paper's set-up: two LiDARs of 16 rings and two cameras, 27 poses of its board in a bare hall, of which 3 to 20
/// (at most as many as a set has) are drawn at random, k in {0, 1, 2}. Each draw is calibrated as `calibrate` does it,
/// in the paper's steps, and in those of its comparators. Errors: cancelled.
[[nodiscard]] Expected<std::vector<BoardRow>> draw_boards(const BoardDrawOptions& options, const RunContext& context);

}  // namespace rigcal
