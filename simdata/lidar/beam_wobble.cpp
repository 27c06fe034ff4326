#include "simdata/lidar/beam_wobble.h"

#include <cmath>

namespace rigcal::sim {

Matrix3d BeamWobble::at(double time_s) const {
  const double turns = turns_per_s * time_s + phase_turns;
  const double angle = 2.0 * pi * (turns - std::floor(turns));
  return exp_so3(amplitude_rad * Vector3d(0.0, std::cos(angle), std::sin(angle)));
}

}  // namespace rigcal::sim
