#pragma once

#include <deque>
#include <optional>
#include <span>

#include "core/stops/motion_bins.h"
#include "core/stops/stop_options.h"

namespace rigcal {

/// Says of each bin whether the rig moved in it. A run of bins is still when every window of 25, 50, 100, 250 and 500
/// ms inside it is: its mean rate is the bias, and its bins scatter as the sensor's noise does. What a window of T must
/// not exceed is made of two parts: what does not matter (an angle of twice the limit in T, or slow creep), and the
/// noise, learned from the stops themselves.
///
/// Bias and noise are not known at first. The first half second in which the means of the bins scatter no more than the
/// samples inside the bins foretell, and whose rate could be a bias, gives both. A steady rotation looks the same, so
/// the last few steady stretches vote: a level that more of them share replaces the bias.
class StillJudge {
 public:
  explicit StillJudge(const StopOptions& options) : options_(options) {}

  void add(const MotionBin& bin);
  /// The next bin whose verdict can not change any more (about 0.7 s behind); with `at_end` also the rest.
  [[nodiscard]] std::optional<MotionBin> take_final(bool at_end);
  /// Refines bias and noise with the bin taken last, which was found to be in a stop.
  void learn_from_last();

  /// The bin taken last, up to two seconds before it, and the still bins that are known after it.
  struct Surroundings {
    std::span<const MotionBin> bins;
    std::size_t last;  ///< Index of the bin taken last.
  };
  [[nodiscard]] Surroundings around_last() const;
  /// When the rotation before the bin taken last, the first still one, most likely ended: a slow one hides in the
  /// noise.
  [[nodiscard]] std::int64_t turn_faded_ns() const;
  [[nodiscard]] const Vector3d& bias() const { return bias_; }
  /// Variance of a gyro sample for each axis as it shows in means over 25 ms and more, (rad/s)^2.
  [[nodiscard]] const Vector3d& noise_variance() const { return noise_; }
  /// The lowest noise of half a second so far, 1 sigma of a sample, mean over the axes, rad/s; also without a stop.
  [[nodiscard]] double lowest_noise_rad_s() const;
  [[nodiscard]] int bias_changes() const { return bias_changes_; }

 private:
  struct Window;
  struct Level {
    Vector3d mean = Vector3d::Zero();
    double samples = 0.0;
  };
  [[nodiscard]] Window window(std::int64_t first, std::int64_t last) const;
  [[nodiscard]] bool turns(const Window& w) const;
  [[nodiscard]] bool shakes(const Window& w) const;
  [[nodiscard]] bool bumps(const Window& w) const;
  [[nodiscard]] bool is_steady(const Window& w) const;
  void judge(std::int64_t last);
  [[nodiscard]] std::int64_t onset(std::int64_t last) const;
  void judge_all();
  void mark_gap(std::int64_t last);
  void mark_moving(std::int64_t first, std::int64_t last);
  void watch_level(std::int64_t last);
  [[nodiscard]] bool agree(const Level& a, const Level& b) const;
  void vote(const Level& level, const Window& w);
  void adopt(const Level& level, const Window& w);
  [[nodiscard]] MotionBin& at(std::int64_t index) { return bins_[static_cast<std::size_t>(index - begin_)]; }
  [[nodiscard]] const MotionBin& at(std::int64_t index) const {
    return bins_[static_cast<std::size_t>(index - begin_)];
  }

  StopOptions options_;
  std::vector<MotionBin> bins_;  ///< Bins begin_ .. end_ - 1, the last few seconds.
  std::int64_t begin_ = 0;
  std::int64_t end_ = 0;
  std::int64_t final_ = 0;  ///< The first bin whose verdict is open.

  bool knows_bias_ = false;
  Vector3d bias_ = Vector3d::Zero();
  Vector3d noise_ = Vector3d::Zero();
  double bump_noise_ = 0.0;  ///< Variance of a bin's mean acceleration, summed over the axes, g^2.
  double learned_bins_ = 0.0;
  double lowest_noise2_ = -1.0;
  int bias_changes_ = 0;

  std::deque<Level> levels_;  ///< The last steady stretches, one entry each.
  Level stretch_;             ///< The one that goes on, as it began.
  int steady_bins_ = 0;
  bool same_rest_ = false;  ///< No unsteadiness since the last vote.
  int unsteady_bins_ = 0;
};

}  // namespace rigcal
