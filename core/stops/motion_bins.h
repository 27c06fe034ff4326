#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "core/records/records.h"

namespace rigcal {

/// What an inertial unit said in one slot of 25 ms.
struct MotionBin {
  static constexpr std::int64_t length_ns = 25'000'000;
  static constexpr double length_s = 0.025;

  std::int64_t start_ns = 0;
  int samples = 0;
  Vector3d gyro_mean = Vector3d::Zero();     ///< rad/s
  Vector3d gyro_scatter = Vector3d::Zero();  ///< Sum of squared deviations from the mean, (rad/s)^2.
  Vector3d acceleration_mean = Vector3d::Zero();
  Vector3d turn =
      Vector3d::Zero();             ///< Integral of the gyro (trapezoids) over the sample intervals that end here, rad.
  double turn_s = 0.0;              ///< The length of those intervals.
  double longest_interval_s = 0.0;  ///< The longest of them.
  bool moving = false;              ///< Filled by the judge,
  bool silent = false;              ///< and this: counts as moving as the unit said nothing for too long.

  [[nodiscard]] std::int64_t end_ns() const { return start_ns + length_ns; }
};

/// Puts the samples of one inertial unit in order (those up to 20 ms late), drops doubles and nonsense, and sums them
/// into consecutive bins. The grid starts at the first sample. A silence gives empty bins, at most `max_empty_bins`;
/// after a longer one the grid starts anew.
class MotionBinner {
 public:
  static constexpr int max_empty_bins = 64;

  /// The bins that this sample completes; valid until the next call.
  [[nodiscard]] const std::vector<MotionBin>& add(const ImuSample& sample);
  /// The bins that were still open, but for one that the stream's end cut.
  [[nodiscard]] const std::vector<MotionBin>& flush();

  [[nodiscard]] std::uint64_t used() const { return used_; }
  [[nodiscard]] std::uint64_t unusable() const { return unusable_; }  ///< Too late, impossible values or time.

 private:
  void release(const ImuSample& sample);
  void open_bin_for(std::int64_t stamp_ns);

  std::vector<ImuSample> waiting_;  ///< In order of time.
  std::vector<MotionBin> ready_;
  MotionBin open_;
  bool has_open_ = false;
  ImuSample last_;
  std::int64_t last_ns_ = std::numeric_limits<std::int64_t>::min();
  std::uint64_t used_ = 0;
  std::uint64_t unusable_ = 0;
};

}  // namespace rigcal
