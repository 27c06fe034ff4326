#pragma once

#include <algorithm>
#include <cstdint>
#include <deque>
#include <functional>
#include <limits>
#include <map>
#include <utility>

#include "core/records/records.h"

namespace rigcal {

/// Inertial readings of a bag, held back until the clouds of their time have come. Readings end a stop, and a cloud
/// comes only when it is complete: a whole period after its first point, when its stop may be over. None waits for
/// longer than two and a half seconds, for a LiDAR may fall silent.
class ImuQueue {
 public:
  using Sink = std::function<void(const ImuSample&)>;
  explicit ImuQueue(Sink sink) : sink_(std::move(sink)) {}

  /// The readings wait for the points of this LiDAR, too.
  void wait_for(int lidar) { seen_until_ns_[lidar] = std::numeric_limits<std::int64_t>::min(); }
  /// The points of a LiDAR have come up to this session time.
  void seen(int lidar, std::int64_t until_ns) {
    std::int64_t& seen_ns = seen_until_ns_[lidar];
    seen_ns = std::max(seen_ns, until_ns);
  }
  void add(const ImuSample& sample, std::int64_t recorded_ns) { held_.push_back({sample, recorded_ns}); }
  /// Gives on what need not wait any longer; `recorded_ns` is how far the bag is read.
  void hand_on(std::int64_t recorded_ns) {
    std::int64_t seen_ns = std::numeric_limits<std::int64_t>::max();
    for (const auto& [lidar, until_ns] : seen_until_ns_) seen_ns = std::min(seen_ns, until_ns);
    while (!held_.empty() &&
           (held_.front().sample.stamp_ns <= seen_ns || recorded_ns - held_.front().recorded_ns > longest_wait_ns))
      give_first();
  }
  /// At the end of the bag.
  void flush() {
    while (!held_.empty()) give_first();
  }

 private:
  // A cloud of two seconds, the longest one that is believed, and its way.
  static constexpr std::int64_t longest_wait_ns = 2'500'000'000;
  struct Held {
    ImuSample sample;
    std::int64_t recorded_ns;
  };
  void give_first() {
    if (sink_) sink_(held_.front().sample);
    held_.pop_front();
  }

  Sink sink_;
  std::map<int, std::int64_t> seen_until_ns_;  ///< By LiDAR.
  std::deque<Held> held_;
};

}  // namespace rigcal
