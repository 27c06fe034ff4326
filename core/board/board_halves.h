#pragma once

#include <vector>

#include "core/board/board_adjustment.h"

namespace rigcal {

/// How far the earlier and the later half of the boards disagree about a sensor's place: a mount that slipped by less
/// than what tells boards apart.
struct BoardHalves {
  bool compared = false;     ///< Four boards and more of each half tell.
  int first_later_stop = 0;  ///< With which the later half begins; as BoardPlace::stop.
  /// Of the difference over its covariance; 22.5 is exceeded by chance in one of a thousand.
  double chi2 = 0.0;
  double rotation_rad = 0.0;  ///< The difference itself.
  double translation_m = 0.0;
};

/// Of each sensor, by adjusting each half alone with the noise that was found for all.
[[nodiscard]] std::vector<BoardHalves> compare_board_halves(const BoardAdjustment& found, const BoardModel& board,
                                                            const BoardAdjustOptions& options);

}  // namespace rigcal
