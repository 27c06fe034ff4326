#pragma once

#include <optional>
#include <span>

#include "core/stops/motion_bins.h"

namespace rigcal {

/// A mean over a bin of 25 ms of what swings (rates or angles), each axis over its noise.
struct SwingReading {
  std::size_t bin = 0;
  double weight = 1.0;  ///< 1 / variance of `value`.
  Vector3d value = Vector3d::Zero();
};

/// A damped sine; its amplitude on each axis at the bin `start_bin`, over the noise as the readings are.
struct SwingFit {
  double hz = 0.0;
  double decay_s = 0.0;
  double explained = 0.0;                                                        ///< Energy in units of the noise.
  Eigen::Matrix<double, 2, 3> amplitudes = Eigen::Matrix<double, 2, 3>::Zero();  ///< Of cosine and sine.
  std::size_t start_bin = 0;
};

/// What counts as a swing; the defaults fit a gyro's rates.
struct SwingLimits {
  double highest_hz = 14.0;
  double least_cycles = 0.0;  ///< In one decay time; fewer: the end of a motion rather than a swing.
  /// In units of the noise: noise alone explains 6 by the amplitudes and a few by the search.
  double least_explained = 30.0;
};

/// The noise hides the end of a swing, so it is foretold: a damped sine is fitted by least squares to the readings (in
/// order, at most one a bin), from the latest ones backwards for as long as it explains them. `still_from`: index of
/// the first reading in which nothing stood out. None where no swing is to be seen.
[[nodiscard]] std::optional<SwingFit> fit_swing(std::span<const SwingReading> readings, std::size_t still_from,
                                                const SwingLimits& limits);

/// How long after the start of `start_bin` a swing of `amplitude` there has fallen to `limit`, s.
[[nodiscard]] double fading_s(const SwingFit& fit, double amplitude, double limit);

/// When the swing after a motion has fallen to `angle_limit_rad` (amplitude), session ns; the lowest int64 where no
/// swing is to be seen.
///
/// `bins` run from the motion into the rest, oldest first; `first_still` is the index of the first one in which nothing
/// stood out. `noise_variance` is that of a gyro sample for each axis, (rad/s)^2.
[[nodiscard]] std::int64_t swing_settled_ns(std::span<const MotionBin> bins, std::size_t first_still,
                                            const Vector3d& gyro_bias, const Vector3d& noise_variance,
                                            double angle_limit_rad);

}  // namespace rigcal
