#include "core/camera/camera_checks.h"

#include "core/base/median.h"
#include "core/base/parallel.h"

namespace rigcal {
namespace {

// Of a normal distribution, from the median of the absolute values; 0 of none.
double robust_rms(std::vector<double> values) {
  for (double& v : values) v = std::abs(v);
  return sigma_per_median_size * median(std::move(values));
}

// Below this share of a segment the partners are as likely clutter.
constexpr double least_share = 0.5;

template <class Visit>
void for_each_view(const CameraScene& scene, const CameraIntrinsics& intrinsics, const CameraState& state,
                   std::span<const EdgeView> views, const Visit& visit) {
  const CameraModel model(changed(intrinsics, state));
  for (const EdgeView& view : views) {
    visit(view, camera_at(model, state, scene.T_G_base[static_cast<std::size_t>(view.stop)]));
  }
}

}  // namespace

EdgeFitQuality fit_quality(const CameraScene& scene, const CameraIntrinsics& intrinsics, const CameraState& state,
                           const MatchOptions& options, std::span<const EdgeView> views) {
  EdgeFitQuality quality;
  std::vector<double> normalised;
  std::vector<double> pixels;
  for_each_view(scene, intrinsics, state, views, [&](const EdgeView& view, const CameraAtStop& camera) {
    const std::size_t before = pixels.size();
    for (const SegmentFit& fit : match_view(scene, view, camera, options)) {
      quality.edge_points += static_cast<std::size_t>(fit.matched);
      if (fit.share() < least_share) continue;
      pixels.push_back(fit.offset_px);
      normalised.push_back(fit.offset_px / fit.expected_px);
    }
    if (pixels.size() > before) ++quality.views;
  });
  quality.segments = pixels.size();
  quality.residual_px = robust_rms(std::move(pixels));
  quality.normalised = robust_rms(std::move(normalised));
  return quality;
}

double offset_from(const CameraScene& scene, const CameraIntrinsics& intrinsics, const CameraState& state,
                   const CameraState& other, const MatchOptions& options, std::span<const EdgeView> views) {
  const CameraModel other_model(changed(intrinsics, other));
  std::vector<double> offsets;
  for_each_view(scene, intrinsics, state, views, [&](const EdgeView& view, const CameraAtStop& camera) {
    std::vector<EdgeMatch> matches;
    (void)match_view(scene, view, camera, options, &matches);
    const CameraAtStop there = camera_at(other_model, other, scene.T_G_base[static_cast<std::size_t>(view.stop)]);
    for (const EdgeMatch& match : matches) {
      if (match.weight < 0.5) continue;
      const auto projection = project_edge(there, scene.edges[match.sample]);
      if (projection) offsets.push_back(match.normal.dot(projection->pixel - match.position));
    }
  });
  return robust_rms(std::move(offsets));
}

ScalarEstimate corner_shift(const CameraIntrinsics& intrinsics, const CameraState& state,
                            const Eigen::Matrix2d& covariance) {
  const CameraModel model(intrinsics);
  const Eigen::Vector2d corner(intrinsics.cx < 0.5 * intrinsics.width ? intrinsics.width - 1.0 : 0.0,
                               intrinsics.cy < 0.5 * intrinsics.height ? intrinsics.height - 1.0 : 0.0);
  const auto ray = model.ray(corner);
  PixelDerivatives derivatives;
  if (!ray || !model.project(*ray, derivatives)) return {};
  const Eigen::Vector2d outwards = (corner - Eigen::Vector2d(intrinsics.cx, intrinsics.cy)).normalized();
  const Eigen::Vector2d by_focal =
      derivatives.by_intrinsics.col(0) * intrinsics.fx + derivatives.by_intrinsics.col(1) * intrinsics.fy;
  const Eigen::Vector2d row(outwards.dot(by_focal), outwards.dot(derivatives.by_intrinsics.col(4)));
  return {row.dot(Eigen::Vector2d(state.focal_scale, state.k1_change)), std::sqrt(row.dot(covariance * row))};
}

}  // namespace rigcal
