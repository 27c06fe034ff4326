#include "core/camera/edge_views.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <set>

#include "core/base/parallel.h"
#include "core/camera/depth_buffer.h"
#include "core/camera/sightings.h"

namespace rigcal {
namespace {

// The same camera with a larger image.
CameraIntrinsics widened(CameraIntrinsics intrinsics, double margin_px) {
  const int margin = static_cast<int>(std::ceil(margin_px));
  intrinsics.width += 2 * margin;
  intrinsics.height += 2 * margin;
  intrinsics.cx += margin;
  intrinsics.cy += margin;
  return intrinsics;
}

DepthBufferOptions with_stride(std::size_t stride) {
  DepthBufferOptions options;
  options.stride = stride;
  return options;
}

class VisibleFinder {
 public:
  VisibleFinder(const CameraScene& scene, const CameraAtStop& camera, const VisibleOptions& options)
      : scene_(scene),
        camera_(camera),
        spacing_px_(options.spacing_px),
        depth_(camera.model, camera.T_C_G, scene.samples, scene.blocks, with_stride(options.stride)) {}

  void run(const std::vector<std::uint32_t>& by_line, EdgeView& view) const {
    view.samples.clear();
    view.segments.clear();
    Eigen::Vector2d last = Eigen::Vector2d::Zero();
    for (const std::uint32_t i : by_line) {
      const LidarEdge& edge = scene_.edges[i];
      const Vector3d p_C = camera_.T_C_G * edge.p_G;
      const auto pixel = camera_.model.project(p_C);
      if (!pixel || !camera_.model.contains(*pixel, border_px)) continue;
      const bool goes_on = !view.segments.empty() && view.segments.back().line == edge.line;
      if (goes_on && (*pixel - last).norm() < spacing_px_) continue;
      if (!depth_.sees(*pixel, p_C.norm(), edge)) continue;
      const auto at = static_cast<std::uint32_t>(view.samples.size());
      if (!goes_on) view.segments.push_back({edge.line, at, at});
      view.samples.push_back(i);
      view.segments.back().end = at + 1;
      last = *pixel;
    }
  }

 private:
  const CameraScene& scene_;
  const CameraAtStop& camera_;
  double spacing_px_;
  DepthBuffer depth_;
};

}  // namespace

std::vector<EdgeView> make_edge_views(const CameraScene& scene, const CameraTask& camera) {
  std::vector<EdgeView> found(camera.views.size());
  parallel_for(camera.views.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      const CameraView& view = camera.views[k];
      if (!is_usable(scene, camera.intrinsics, view)) continue;
      found[k].stop = view.stop;
      found[k].index = EdgeIndex(view.grey.width, view.grey.height,
                                 view.edges != nullptr ? *view.edges : find_image_edges(view.grey));
    }
  });
  std::vector<EdgeView> views;
  std::map<int, int> of_stop;
  for (EdgeView& view : found) {
    if (view.index.size() == 0) continue;
    ++of_stop[view.stop];
    views.push_back(std::move(view));
  }
  for (EdgeView& view : views) view.weight = 1.0 / of_stop[view.stop];
  return views;
}

std::size_t stops_of(const std::vector<EdgeView>& views) {
  std::set<int> stops;
  for (const EdgeView& view : views) stops.insert(view.stop);
  return stops.size();
}

void find_visible(const CameraScene& scene, const CameraIntrinsics& intrinsics, const CameraState& state,
                  const VisibleOptions& options, std::vector<EdgeView>& views) {
  std::vector<std::uint32_t> by_line(scene.edges.size());
  std::iota(by_line.begin(), by_line.end(), 0U);
  std::stable_sort(by_line.begin(), by_line.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return scene.edges[a].line < scene.edges[b].line; });
  const CameraModel model(widened(changed(intrinsics, state), options.margin_px));
  parallel_for(views.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      const SE3& T_G_base = scene.T_G_base[static_cast<std::size_t>(views[k].stop)];
      VisibleFinder(scene, camera_at(model, state, T_G_base), options).run(by_line, views[k]);
    }
  });
}

}  // namespace rigcal
