#pragma once

#include "core/board/board_images.h"

namespace rigcal {

/// The ChArUco board of the rig file in an image: its inner corners next to markers that were read, so also those of
/// a board that is cut or partly hidden, and with no doubt which is which. At least four corners, not in one line.
[[nodiscard]] ImageBoards find_charuco_board(const GreyImage& grey, const BoardModel& board);

}  // namespace rigcal
