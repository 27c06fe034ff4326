#pragma once

#include <vector>

#include "core/camera/camera_calibration.h"
#include "core/camera/edge_solver.h"

namespace rigcal {

/// Where a camera ends from one start, and what its images say of the intrinsics there.
struct CameraEnd {
  EdgeSolution solution;
  EdgePriors priors;           ///< That it was solved with: those given, or with intrinsics that are free.
  ScalarEstimate focal_scale;  ///< Freely estimated, as in CameraEstimate.
  ScalarEstimate k1_change;
  ScalarEstimate radial_trend;
  ScalarEstimate cx_change_px;
  ScalarEstimate cy_change_px;
  int iterations = 0;
};

/// From fewer stops the rig file is believed rather than the images: nothing could be held out to tell who is right.
constexpr std::size_t least_stops_for_intrinsics = 4;

/// The same priors where intrinsics are to be found: with sigmas that no calibration is off by more than.
[[nodiscard]] EdgePriors with_free_intrinsics(EdgePriors priors);

/// Whether a freely estimated departure from the rig file is more than chance.
[[nodiscard]] bool is_off(const ScalarEstimate& change);

/// As `is_off`, of cx or cy in pixels; `chance_px` is principal_chance_px in those of `change`.
[[nodiscard]] bool is_off_px(const ScalarEstimate& change, double chance_px = principal_chance_px);

/// Matches finely from a start, with all intrinsics free, with those but the principal point, and under the priors:
/// what these should be shows only where nothing pulls them back. Where they are clearly others, the end is a free one;
/// so it is where they are asked for (`refine_intrinsics`), but for a principal point that nothing contradicts. It
/// depends on the start alone, not on what other starts ended with. `views` are what is seen from there.
[[nodiscard]] CameraEnd solve_end(const CameraScene& scene, const CameraTask& camera, bool refine_intrinsics,
                                  const EdgePriors& priors, const CameraState& start, std::vector<EdgeView>& views,
                                  const RunContext& context);

}  // namespace rigcal
