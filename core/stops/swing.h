#pragma once

#include <span>

#include "core/stops/motion_bins.h"

namespace rigcal {

/// When the swing after a motion has fallen to `angle_limit_rad` (amplitude), session ns; the lowest int64 where no
/// swing is to be seen. The noise hides the end of a swing, so it is foretold: a damped sine is fitted by least squares
/// to the bins, from the latest ones backwards for as long as it explains them.
///
/// `bins` run from the motion into the rest, oldest first; `first_still` is the index of the first one in which nothing
/// stood out. `noise_variance` is that of a gyro sample for each axis, (rad/s)^2.
[[nodiscard]] std::int64_t swing_settled_ns(std::span<const MotionBin> bins, std::size_t first_still,
                                            const Vector3d& gyro_bias, const Vector3d& noise_variance,
                                            double angle_limit_rad);

}  // namespace rigcal
