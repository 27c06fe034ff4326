#include "core/camera/stop_agreement.h"

#include <array>
#include <cmath>
#include <map>

#include "core/base/parallel.h"

namespace rigcal {
namespace {

// Poses beside: turned so that pixels move this far, farther than partners reach and than a pose is uncertain by, in so
// many directions each.
constexpr std::array beside_px{12.0, 20.0};
constexpr int directions = 8;

std::vector<CameraState> beside(const CameraIntrinsics& intrinsics, const CameraState& state) {
  std::vector<CameraState> others;
  for (std::size_t ring = 0; ring < beside_px.size(); ++ring) {
    for (int k = 0; k < directions; ++k) {
      const double direction = 2.0 * pi * (k + 0.5 * static_cast<double>(ring)) / directions;
      const Vector3d turn(std::cos(direction) / intrinsics.fy, std::sin(direction) / intrinsics.fx, 0.0);
      CameraState other = state;
      other.T_base_camera.R = state.T_base_camera.R * exp_so3(beside_px[ring] * turn);
      others.push_back(other);
    }
  }
  return others;
}

double explained(const CameraScene& scene, const EdgeView& view, const CameraAtStop& camera,
                 const MatchOptions& options) {
  double sum = 0.0;
  for (const SegmentFit& fit : match_view(scene, view, camera, options)) sum += fit.explained();
  return sum;
}

}  // namespace

std::vector<StopAgreement> agreement_of_stops(const CameraScene& scene, const CameraIntrinsics& intrinsics,
                                              const CameraState& state, const MatchOptions& options,
                                              std::span<const EdgeView> views) {
  const CameraModel model(changed(intrinsics, state));
  const std::vector<CameraState> others = beside(intrinsics, state);
  std::vector<StopAgreement> of_view(views.size());
  parallel_for(views.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      const EdgeView& view = views[k];
      const SE3& T_G_base = scene.T_G_base[static_cast<std::size_t>(view.stop)];
      of_view[k].segments = static_cast<double>(view.segments.size());
      of_view[k].explained = explained(scene, view, camera_at(model, state, T_G_base), options);
      for (const CameraState& other : others) {
        of_view[k].by_chance += explained(scene, view, camera_at(model, other, T_G_base), options);
      }
      of_view[k].by_chance /= static_cast<double>(others.size());
    }
  });
  std::map<int, StopAgreement> stops;
  for (std::size_t k = 0; k < views.size(); ++k) {
    StopAgreement& stop = stops[views[k].stop];
    stop.stop = views[k].stop;
    stop.segments += views[k].weight * of_view[k].segments;
    stop.explained += views[k].weight * of_view[k].explained;
    stop.by_chance += views[k].weight * of_view[k].by_chance;
  }
  std::vector<StopAgreement> sorted;
  for (const auto& [number, stop] : stops) sorted.push_back(stop);
  return sorted;
}

double share_of(std::span<const StopAgreement> stops) {
  StopAgreement sum;
  for (const StopAgreement& stop : stops) {
    sum.segments += stop.segments;
    sum.explained += stop.explained;
    sum.by_chance += stop.by_chance;
  }
  return sum.share();
}

}  // namespace rigcal
