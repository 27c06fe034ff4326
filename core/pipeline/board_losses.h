#pragma once

#include <span>
#include <vector>

#include "core/board/board_adjustment.h"

namespace rigcal {

/// Stops at which a sensor and the one that placed it both saw a board, and yet its board went with no other sensor's.
struct BoardLosses {
  std::vector<int> stops;  ///< In order; as BoardPlace::stop.
  bool together = false;   ///< Three or more, and no stop between them at which it went: a mount that slipped.
};

/// Of `sensor`, which `via` placed. `seen`: by all sensors; `places`: after the adjustment.
[[nodiscard]] BoardLosses lost_boards(int sensor, int via, std::span<const BoardSighting> seen,
                                      std::span<const BoardPlace> places);

}  // namespace rigcal
