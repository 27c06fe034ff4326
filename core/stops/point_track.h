#pragma once

#include <array>
#include <optional>

#include "core/stops/point_slots.h"
#include "core/stops/stop_options.h"

namespace rigcal {

/// The motion of one LiDAR slot by slot against a reference that was taken while it seemed to stand, and whether that
/// is more than noise. The noise of a slot is known from the points but for a factor: patterns do not come back to the
/// same spots and walls are not flat; the building or the vehicle may tremble. The factor is learned at rest.
class PointTrack {
 public:
  /// Windows overlap, there are some hundred a second: chi-square of six, with room for the tails of real noise.
  static constexpr double most_offness = 48.0;

  PointTrack(std::size_t lidar, int sensor, const StopOptions& options);

  /// Slots first .. last become the reference; those before keep no meaning until they are measured anew.
  void take_reference(const PointSlots& slots, std::int64_t first, std::int64_t last);
  void measure(const PointSlots& slots, std::int64_t slot);

  /// The sensor's mean place in slots first .. last, all measured, is off the reference: the square over what noise and
  /// harmless motion explain, of six degrees of freedom. Infinite where most of the view is something else now.
  [[nodiscard]] double offness(std::int64_t first, std::int64_t last) const;
  [[nodiscard]] bool moved(std::int64_t first, std::int64_t last) const { return offness(first, last) > most_offness; }
  [[nodiscard]] bool empty(std::int64_t slot) const { return at(slot).met < 1.0; }

  /// How slots scatter that are at rest.
  struct Scatter {
    double noise_ratio = 1.0;  ///< Variance over what the points alone explain.
    double half_ratio = 1.0;   ///< Energy in the earlier half over that in the later one, or the other way round.
    double tremble_rad = 0.0;  ///< Root mean square of the turning that the points' noise does not explain.
  };
  [[nodiscard]] Scatter scatter(std::int64_t first, std::int64_t last) const;
  void set_noise_ratio(double ratio) { noise_ratio_ = ratio; }
  [[nodiscard]] double noise_ratio() const { return noise_ratio_; }

  /// The turn about the table's axis (where that is not known, the axis that is seen worst) which a quarter of a second
  /// brings out of the noise, rad.
  [[nodiscard]] double resolution_rad() const;
  /// The same about the axis that is seen worst, in `slots` slots.
  [[nodiscard]] double worst_resolution_rad(std::int64_t slots) const;

  /// Rotation of slots first .. last against the reference, rad, and the variance of one slot's on each axis.
  [[nodiscard]] Vector3d turn(std::int64_t first, std::int64_t last) const;
  [[nodiscard]] Vector3d slot_variance() const;

  /// Keeps the reference aside as the previous one.
  void keep_reference();
  /// How slots first .. last are turned against the kept reference (directions of now into then), where that sees the
  /// same view. None where nothing is kept.
  [[nodiscard]] std::optional<Vector3d> turn_from_kept(const PointSlots& slots, std::int64_t first,
                                                       std::int64_t last) const;

 private:
  [[nodiscard]] const RangeMotion& at(std::int64_t slot) const {
    return motions_[static_cast<std::size_t>(slot % PointSlots::kept)];
  }
  [[nodiscard]] double half_change(std::int64_t first, std::int64_t middle, std::int64_t last) const;
  [[nodiscard]] double resolution_of(double turn_variance, double slots) const;
  [[nodiscard]] RangeMotion sum(std::int64_t first, std::int64_t last) const;

  std::size_t lidar_;
  StopOptions options_;
  std::optional<Vector3d> axis_;
  RangeReference reference_;
  std::optional<RangeReference> kept_;
  RangeMotion reference_motion_;  ///< Sum over its own slots.
  Matrix6d reference_covariance_ = Matrix6d::Zero();
  std::int64_t reference_slots_ = 0;
  double noise_ratio_ = 1.0;
  std::array<RangeMotion, static_cast<std::size_t>(PointSlots::kept)> motions_;
};

}  // namespace rigcal
