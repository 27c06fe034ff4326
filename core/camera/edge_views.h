#pragma once

#include <cstdint>
#include <vector>

#include "core/camera/camera_calibration.h"
#include "core/camera/camera_state.h"
#include "core/camera/edge_index.h"

namespace rigcal {

/// So near to its border an image has no edges, and none that a fit holds.
inline constexpr double border_px = 4.0;

/// What an image sees of one line: a stretch of `EdgeView::samples`. It is the unit of all weights, for its samples err
/// together: weighed one by one, a long line near the camera would outweigh all others.
struct EdgeSegment {
  int line = 0;
  std::uint32_t begin = 0;
  std::uint32_t end = 0;
};

/// One image: its edges, and the LiDAR edges that it should show.
struct EdgeView {
  int stop = 0;
  double weight = 1.0;  ///< Images of one stop see the same: together they count once.
  EdgeIndex index;
  std::vector<std::uint32_t> samples;  ///< Of CameraScene::edges, by lines.
  std::vector<EdgeSegment> segments;
};

/// Views with their image edges, in the order of `camera.views`; those of stops that are not known, without an edge or
/// of another size than the intrinsics say are left out.
[[nodiscard]] std::vector<EdgeView> make_edge_views(const CameraScene& scene, const CameraTask& camera);

/// How many stops they are of.
[[nodiscard]] std::size_t stops_of(const std::vector<EdgeView>& views);

/// How much more than the image is looked at, and how densely.
struct VisibleOptions {
  double margin_px = 0.0;   ///< Beyond the image's border: where the pose is only roughly known.
  double spacing_px = 6.0;  ///< Samples that lie closer in the image say nothing new.
  std::size_t stride = 1;   ///< As of a depth buffer.
};

/// For starts, which are compared by few samples and not near to where they end: rotations of a guess move pixels so
/// far beyond the image's border, at its sigma, and what hides samples need be known no better than where they are.
inline constexpr VisibleOptions sparse_view{80.0, 8.0, 3};

/// Fills in what each view sees from `state`, by the depth of the map.
void find_visible(const CameraScene& scene, const CameraIntrinsics& intrinsics, const CameraState& state,
                  const VisibleOptions& options, std::vector<EdgeView>& views);

}  // namespace rigcal
