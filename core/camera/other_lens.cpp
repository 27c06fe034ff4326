#include "core/camera/other_lens.h"

#include <utility>

#include "core/camera/edge_search.h"

namespace rigcal {
namespace {

// Segments that image edges explain, of what is seen from there.
double explained(const CameraScene& scene, const CameraIntrinsics& intrinsics, const CameraState& state,
                 std::vector<EdgeView>& views) {
  VisibleOptions visible;
  visible.stride = sparse_view.stride;
  find_visible(scene, intrinsics, state, visible, views);
  return sum_segments(scene, intrinsics, state, standard_levels().back().match, views).explained;
}

}  // namespace

CameraIntrinsics other_lens(const CameraIntrinsics& intrinsics) {
  CameraIntrinsics other = intrinsics;
  const bool is_wide = intrinsics.model == DistortionModel::equidistant;
  other.model = is_wide ? DistortionModel::radtan : DistortionModel::equidistant;
  other.distortion.assign(distortion_count(other.model), 0.0);
  return other;
}

double other_lens_gain(const CameraScene& scene, const CameraIntrinsics& intrinsics, const CameraState& end,
                       const EdgePriors& priors, std::vector<EdgeView>& views, const RunContext& context) {
  const double own = explained(scene, intrinsics, end, views);
  const CameraIntrinsics other = other_lens(intrinsics);
  const SE3& centre = priors.T_base_camera;
  find_visible(scene, other, CameraState{centre}, sparse_view, views);
  std::vector<SE3> starts = search_edges(scene, other, centre, priors, views);
  starts.push_back(centre);
  EdgeSolution best;
  for (const SE3& start : starts) {
    if (context.cancelled()) return 0.0;
    EdgeSolution solved = solve_edges(scene, other, CameraState{start}, priors, standard_levels(), views, context);
    if (solved.score > best.score) best = std::move(solved);
  }
  return own > 0.0 && best.score > 0.0 ? explained(scene, other, best.state, views) / own : 0.0;
}

}  // namespace rigcal
