#pragma once

#include <cstdint>
#include <vector>

#include "core/camera/camera_calibration.h"
#include "core/camera/surface_codes.h"
#include "core/rig/camera_model.h"

namespace rigcal {

/// A sample of the map as a camera sees it in one view.
struct Sighting {
  Eigen::Vector3f p_base = Eigen::Vector3f::Zero();  ///< In the rig's frame at the view's stop.
  std::uint16_t view = 0;                            ///< Index into CameraTask::views.
  std::uint8_t code = 0;                             ///< What is known of the surface.
};

struct SightingOptions {
  std::size_t max_samples = 0;    ///< So many of the map's samples hide others; 0: all.
  std::size_t max_sightings = 0;  ///< Of all views together; 0: all.
  double margin_px = 0.0;         ///< From the image's border; negative: also so far outside.
  /// Leave out what is so near to a silhouette, in cells of the depth buffer: the map's silhouettes are blunt, and the
  /// image has the background there. 0: keep all.
  int silhouette_cells = 0;
};

/// Whether a view can be used at all: its stop is known, and it has the size that the intrinsics say.
[[nodiscard]] bool is_usable(const CameraScene& scene, const CameraIntrinsics& intrinsics, const CameraView& view);

/// What a camera at `T_base_camera` sees of the map in its views, those of unknown stops left out. In the order of the
/// views; deterministic whatever the number of threads.
[[nodiscard]] std::vector<Sighting> find_sightings(const CameraScene& scene, const SurfaceCodes& codes,
                                                   const CameraTask& camera, const CameraModel& model,
                                                   const SE3& T_base_camera, const SightingOptions& options);

/// A camera without distortion that looks the same way and sees `margin_rad` farther on all sides, with pixels
/// `coarseness` times as wide: for what may come into view when it is turned.
[[nodiscard]] CameraModel widened(const CameraModel& model, double margin_rad, double coarseness);

}  // namespace rigcal
