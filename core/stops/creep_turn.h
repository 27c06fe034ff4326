#pragma once

#include <limits>
#include <map>

#include "core/stops/still_listener.h"
#include "core/stops/stop_options.h"

namespace rigcal {

/// How far a rig crept after the end of a stop that was cut there, by the rests that the points found in what is left
/// out. A gyro takes creep for its bias: the turn that it tells begins where the creep ended.
class CreepTurn {
 public:
  /// `begin_ns`: where the stop was cut.
  CreepTurn(const StopOptions& options, std::int64_t begin_ns) : options_(options), begin_ns_(begin_ns) {}
  /// Where the gyro's stop ended.
  void end(std::int64_t end_ns) { end_ns_ = end_ns; }
  /// A rest of the points, in order of time; one that did not begin in what is left out does not count.
  void add(const StillStop& rest);
  /// Puts it before the gyro's turn of the stop that follows.
  void put_before(StillStop& next) const;

 private:
  StopOptions options_;
  std::int64_t begin_ns_;
  std::int64_t end_ns_ = std::numeric_limits<std::int64_t>::max();
  std::map<int, Vector3d> turns_rad_;  ///< By the LiDAR that told them, in its axes: creep is slow and has one axis.
  double variance_ = 0.0;
  bool any_rest_ = false;
  bool has_hole_ = false;  ///< There was a rest of which nobody knows how it stands to the one before.
};

}  // namespace rigcal
