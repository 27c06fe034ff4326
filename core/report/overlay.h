#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/camera/camera_calibration.h"
#include "core/quality/result.h"
#include "core/records/image.h"
#include "core/rig/camera_model.h"

/// A camera's images with what the LiDARs saw drawn into them: where an extrinsic is wrong, one sees it here.
namespace rigcal {

/// Which part of an image is drawn, and how large. Without a width: all of it.
struct OverlayWindow {
  int x = 0;
  int y = 0;
  int width = 0;
  int height = 0;
  double scale = 1.0;  ///< Pixels of the picture a pixel of the image.
};

/// Where the world lies in the camera's frame; what is empty is not drawn.
struct OverlayPoses {
  std::optional<SE3> guess_T_C_G;
  std::optional<SE3> T_C_G;
};

/// Rows above the image with title and legend.
constexpr int overlay_legend_rows = 26;

/// Colours that are told apart whatever the colour vision (Okabe and Ito 2008): orange the guess, sky blue the result.
using Rgb = std::array<std::uint8_t, 3>;
constexpr Rgb guess_rgb{230, 159, 0};
constexpr Rgb result_rgb{86, 180, 233};

/// The image in grey with the LiDAR edges that the camera sees from either pose.
[[nodiscard]] Image draw_edges(const GreyImage& grey, const CameraModel& model, const CameraScene& scene,
                               const OverlayPoses& poses, const std::string& title, const OverlayWindow& window = {});

enum class MapColour { range, reflectivity };

/// The image in grey with the samples of the map that the camera sees as dots, dark to bright with the range (in equal
/// ratios) or the reflectivity.
[[nodiscard]] Image draw_map(const GreyImage& grey, const CameraModel& model, const CameraScene& scene,
                             const SE3& T_C_G, MapColour colour, const std::string& title,
                             const OverlayWindow& window = {});

/// Indices of up to `count` views of a camera that sits at `T_base_camera`: those with most edges in sight, first such
/// as look at least 30 degrees past each other, and never two of a stop.
[[nodiscard]] std::vector<std::size_t> choose_views(const CameraScene& scene, const CameraTask& camera,
                                                    const CameraModel& model, const SE3& T_base_camera,
                                                    std::size_t count);

/// How much is drawn for a result: a picture has about 0.2 MB.
struct OverlayBudget {
  std::size_t edge_views = 3;  ///< Pictures with edges a camera,
  std::size_t map_views = 1;   ///< and how many of the same views are also drawn with the map.
  int max_width = 1280;        ///< Larger images are drawn smaller.
  int jpeg_quality = 85;
};

/// The pictures of one camera for a result: of a camera that was not found only the guess. Empty where there is neither
/// a pose nor a view.
[[nodiscard]] std::vector<Overlay> draw_overlays(const CameraScene& scene, const CameraTask& camera,
                                                 const CameraEstimate& estimate, const OverlayBudget& budget = {});

}  // namespace rigcal
