#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/corner/fitted_plane.h"

namespace rigcal {

struct RansacOptions {
  std::size_t planes = 3;
  double threshold_m = 0.25;  ///< A point this near belongs to the plane: two and a half sigmas of the paper's noise.
  double min_share = 0.05;    ///< Of all points; a plane with fewer is none.
  int max_draws = 3000;
  std::uint64_t seed = 1;
};

/// Planes one after the other, the largest first: three points drawn many times, the plane with the most points within
/// the threshold, least squares through these until they stay the same; they are taken out before the next search. The
/// same points in the same order and seed give the same planes. Fewer than asked for where no more are found.
[[nodiscard]] std::vector<FittedPlane> ransac_planes(std::span<const Vector3d> points, const RansacOptions& options);

}  // namespace rigcal
