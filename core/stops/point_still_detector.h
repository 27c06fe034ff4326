#pragma once

#include <deque>

#include "core/stops/point_track.h"
#include "core/stops/still_listener.h"

namespace rigcal {

/// Figures for messages and `inspect`.
struct PointStillFigures {
  std::uint64_t points = 0;  ///< Looked at.
  int stops = 0;
  double longest_still_s = 0.0;  ///< Also of rests too short to be a stop, and of those that nothing confirms.
  /// The turn that the LiDAR which saw best could tell from noise in a quarter of a second, at the rest where that was
  /// best, rad; 0: there never was a rest.
  double resolution_rad = 0.0;
  /// Seconds in which nothing seemed to move, but no LiDAR saw enough surfaces to tell.
  double blind_s = 0.0;
};

/// Finds the still intervals of a rig from what its LiDARs see, without an inertial unit: causal, bounded memory,
/// verdicts at most two seconds behind the stream. Each LiDAR compares, slot by slot, where the surfaces around it are
/// with where they were in the first half second of the rest (PointTrack). The rig stands while none of them is off,
/// over any of several lengths of time: short ones show jerks, the long ones creep; it counts as standing only while
/// one of them would see a turn about any axis.
class PointStillDetector {
 public:
  PointStillDetector(const StopOptions& options, StillListener& listener);
  void add(const PointBatch& batch);
  /// The end of the stream: closes the last stop.
  void flush();
  [[nodiscard]] PointStillFigures figures() const;
  [[nodiscard]] std::optional<RestNow> rest() const;

 private:
  enum class State { moving, still };
  void step();
  void restart();
  void look_for_rest(std::int64_t slot);
  void take_references(std::int64_t first, std::int64_t last);
  [[nodiscard]] bool confirms(std::int64_t last);
  void begin_rest(std::int64_t last);
  [[nodiscard]] std::int64_t settled_ns(std::int64_t first, std::int64_t last) const;
  void compare_with_stop_before(std::int64_t first, std::int64_t last);
  void extend_rest(std::int64_t slot);
  void end_rest(std::int64_t onset, StopEnd end);
  [[nodiscard]] bool moved(std::int64_t first, std::int64_t last) const;
  [[nodiscard]] bool is_outvoted(std::size_t lidar, std::int64_t first, std::int64_t last) const;
  [[nodiscard]] bool moved_just_now(std::int64_t last) const;
  [[nodiscard]] double offness(std::int64_t first, std::int64_t last) const;
  [[nodiscard]] std::int64_t onset(std::int64_t last) const;
  [[nodiscard]] std::int64_t silent_slots(std::int64_t last) const;
  void say_still(std::int64_t until_ns);
  void not_still(std::int64_t until_ns, DropReason reason);

  StopOptions options_;
  StillListener& listener_;
  PointSlots slots_;
  std::deque<PointTrack> tracks_;  ///< One for each LiDAR of `slots_`.
  int epoch_ = 0;
  State state_ = State::moving;
  std::int64_t rest_ = 0;       ///< The first slot of the rest, or of what may become one.
  bool has_reference_ = false;  ///< While moving: from the first slots after `rest_`.
  std::int64_t floor_ = 0;      ///< A rest does not reach back before this slot.
  std::int64_t reference_last_ = 0;
  int reference_grown_ = 0;
  bool knows_noise_ = false;
  StillStop open_;
  bool said_ = false;  ///< The listener was told of the stop.
  PointStillFigures figures_;
};

}  // namespace rigcal
