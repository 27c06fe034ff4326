#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/base/run_context.h"

namespace rigcal {

/// Livox sensors without rings to a camera, by poses of a board at 2.6 to 4.5 m.
struct LivoxRow {
  std::string model;
  int rigs = 0;
  int answers = 0;
  double rotation_rad = 0.0;  ///< Medians over the rigs with an answer,
  double translation_m = 0.0;
  double worst_rotation_rad = 0.0;  ///< and the worst.
  double worst_translation_m = 0.0;
  int shown = 0;        ///< Boards, in all rigs,
  int found = 0;        ///< and found in the clouds.
  double size_m = 0.0;  ///< How far sides of the plates found are off, median over boards and sides,
  double worst_size_m = 0.0;
  double plane_low_m = 0.0;   ///< Root mean square distances of the points from the plates' planes, least
  double plane_high_m = 0.0;  ///< and most.
  int signs = 0;              ///< Rigs whose dark squares seem 1 mm or more nearer or farther,
  int signs_right = 0;        ///< and of these found so.
};

struct LivoxBoardOptions {
  int rigs = 10;
  int poses = 10;
  std::uint64_t seed = 1;
};

/// A MID-40 and an AVIA with the scan patterns of the simulator, each beside a camera: `rigs` rigs with poses of their
/// own, planes 5 to 11 mm thick (rms), dark squares 1 to 9 mm nearer or farther than bright ones, whole footprints.
/// Errors: cancelled.
[[nodiscard]] Expected<std::vector<LivoxRow>> try_livox_boards(const LivoxBoardOptions& options,
                                                               const RunContext& context);

}  // namespace rigcal
