#pragma once

#include <cstdint>
#include <deque>
#include <optional>

#include "core/clocks/device_clock.h"
#include "core/io/ros_messages.h"
#include "core/records/records.h"

namespace rigcal {

/// When the clouds of one topic were seen, in session time. A cloud is sent when it is complete, so its last point is
/// what the clock maps to the record time; but whoever writes a bag anew may give the header's stamp as record time,
/// and that may be of the first point. Then record time is the sender's own.
class CloudTimes {
 public:
  /// Sets the times of a batch, and the shot of each point of the cloud. Without times all that is known is that the
  /// points were seen within the topic's usual period; false: that is not known before the next cloud has come, and the
  /// batch has its end as its stamp.
  [[nodiscard]] bool set(DeviceClock& clock, RosCloud& cloud, std::int64_t recorded_ns, PointBatch& batch);
  /// Until when the points of the topic have come.
  [[nodiscard]] std::int64_t end_ns() const { return *end_ns_; }
  /// Whether clouds were recorded before their last point was seen.
  [[nodiscard]] bool recorded_too_early() const { return too_early_; }
  /// The median of the last steps from cloud to cloud; 0: there was none.
  [[nodiscard]] std::int64_t usual_ns() const;

 private:
  [[nodiscard]] std::int64_t note_end(std::int64_t end_ns);

  std::optional<std::int64_t> end_ns_;  ///< Of the cloud before.
  std::deque<std::int64_t> steps_ns_;
  bool too_early_ = false;
};

}  // namespace rigcal
