#pragma once

#include "core/stops/motion_bins.h"

namespace rigcal {

/// Counts the pauses between turns in which no stop was found: rests that ended before the swing of the turn had faded
/// and a stop was long enough. A pause is where a rig that turned by 5 degrees and more before and does so afterwards
/// stays within half a degree for 0.3 to 3 s, at a fifth of the rate of the turns at most. One who pushes a rig
/// straight on between two turns pauses likewise.
class BriefRests {
 public:
  /// Bins in order of time, none left out. `in_stop`: a stop is known to hold this one.
  void add(const MotionBin& bin, const Vector3d& gyro_bias_rad_s, bool in_stop);

  [[nodiscard]] int count() const { return count_; }
  [[nodiscard]] double longest_s() const { return longest_s_; }

 private:
  /// The rig stayed within half a degree in it.
  struct Step {
    Vector3d turn_rad = Vector3d::Zero();
    double length_s = 0.0;
    bool in_stop = false;
  };
  void end_step();
  void forget();

  Step step_;
  double turned_rad_ = 0.0;     ///< Since the last pause or stop,
  double fastest_rad_s_ = 0.0;  ///< and the highest rate of it.
  double pause_s_ = 0.0;        ///< The last pause, which counts once the rig has turned on; 0: none.
  int count_ = 0;
  double longest_s_ = 0.0;
};

}  // namespace rigcal
