#pragma once

#include "core/geometry/se3.h"

namespace rigcal::sim {

/// The beam goes round a little cone about where the sensor thinks it goes, once a turn of the first prism: its bearing
/// has play.
struct BeamWobble {
  double amplitude_rad = 0.0;
  double turns_per_s = 0.0;
  double phase_turns = 0.0;

  /// Turns a reported direction into the true one, sensor frame; `time_s` since sampling began.
  [[nodiscard]] Matrix3d at(double time_s) const;
};

}  // namespace rigcal::sim
