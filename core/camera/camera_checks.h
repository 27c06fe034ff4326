#pragma once

#include <optional>
#include <span>

#include "core/camera/edge_solver.h"

namespace rigcal {

/// How well a state fits the image edges of some views.
struct EdgeFitQuality {
  std::size_t edge_points = 0;  ///< Samples with a partner,
  std::size_t segments = 0;     ///< segments that are explained by half or more,
  int views = 0;                ///< and views with one.
  double normalised = 0.0;      ///< Robust rms of the segments' offsets over their expected sigma,
  double residual_px = 0.0;     ///< and in pixels.
};

[[nodiscard]] EdgeFitQuality fit_quality(const CameraScene& scene, const CameraIntrinsics& intrinsics,
                                         const CameraState& state, const MatchOptions& options,
                                         std::span<const EdgeView> views);

/// Robust rms in pixels of the offsets that the partners found at `state` have from `other`.
[[nodiscard]] double offset_from(const CameraScene& scene, const CameraIntrinsics& intrinsics, const CameraState& state,
                                 const CameraState& other, const MatchOptions& options,
                                 std::span<const EdgeView> views);

/// What focal scale and k1 of a state do to the pixels at the image's corner, outwards, px; `covariance` of the two.
[[nodiscard]] ScalarEstimate corner_shift(const CameraIntrinsics& intrinsics, const CameraState& state,
                                          const Eigen::Matrix2d& covariance);

}  // namespace rigcal
