#pragma once

#include <array>
#include <cstddef>

namespace rigcal {

/// The lower envelope of (device time, receive time minus device time): a line under all of the last ten seconds.
/// Packets come late, never early, so the earliest of them show the offset of the clocks and its drift; how late the
/// others are does not matter. Kept are the earliest packet of each tenth of a second; the line is the edge of their
/// lower convex hull below the middle of the window (the line that lies closest under all points).
///
/// Times are nanoseconds as double, relative to an origin that the caller chooses. Constant memory, O(1) a packet.
class OffsetLine {
 public:
  /// Forgets the points; keeps the slope, which belongs to the device's crystal.
  void restart(double time, double offset);

  /// True once a tenth of a second is full and the line was fitted anew.
  bool add(double time, double offset);

  [[nodiscard]] double at(double time) const { return offset_ + slope_ * (time - time_); }
  /// Offset per device time, within +-500e-6.
  [[nodiscard]] double slope() const { return slope_; }
  /// From the first point to now.
  [[nodiscard]] double age(double time) const { return time - start_; }

  /// The smallest height above the line of the points of the last two seconds, 0 where the line is younger: a clock
  /// that was set back, or packets that have come to be late for good.
  [[nodiscard]] double recent_height() const;
  /// Forgets all but the last two seconds.
  void keep_recent();

 private:
  struct Early {
    double time = 0.0;
    double offset = 0.0;
  };
  static constexpr std::size_t kCapacity = 100;
  static constexpr std::size_t kRecent = 20;

  void close_bin(double time);
  void fit(double now);
  [[nodiscard]] double hull_slope() const;
  [[nodiscard]] const Early& early(std::size_t i) const { return ring_[(first_ + i) % kCapacity]; }

  std::array<Early, kCapacity> ring_{};
  std::size_t first_ = 0;
  std::size_t count_ = 0;
  Early open_;  ///< Earliest point of the tenth of a second that is still open.
  double bin_start_ = 0.0;
  double start_ = 0.0;
  double lowered_ = 0.0;  ///< How far single points have pulled the line down since the last fit.
  double time_ = 0.0;
  double offset_ = 0.0;
  double slope_ = 0.0;
};

}  // namespace rigcal
