#pragma once

#include <span>
#include <vector>

#include "core/rig/camera_model.h"
#include "simdata/scene/ray_caster.h"
#include "simdata/scene/scene.h"
#include "simdata/scene/scene_light.h"

namespace rigcal::sim {

/// The light that falls on each pixel of a camera, rows from the top; 1 fills a pixel in 5 ms.
struct LightField {
  int width = 0;
  int height = 0;
  std::vector<Color> pixels;

  [[nodiscard]] const Color& at(int x, int y) const {
    return pixels[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)];
  }
};

/// Renders what a camera sees of a scene: four rays a pixel, sixteen where surfaces meet, at places that differ from
/// pixel to pixel so that edges lie where they are on average; textures, sun, lamps and their shadows, panes, mirrors
/// and puddles, people at their place, the lens' vignetting (the square of the cosine from its axis). The references
/// must outlive the renderer.
class ImageRenderer {
 public:
  ImageRenderer(const Scene& scene, const RayCaster& caster, const CameraModel& camera);

  /// On all threads; the same bits for any number of them. What the camera's model cannot project is black.
  [[nodiscard]] LightField render(const SE3& T_scene_camera, double time_s) const;

 private:
  static constexpr int tile_px = 8;
  static constexpr int pixel_rays = 4;
  static constexpr int edge_rays = 16;

  struct Sight;
  struct Tile;
  struct View {
    SE3 T_scene_camera;
    RayCaster::People people;
  };
  void render_tile(const View& view, int tile_x, int tile_y, LightField& out) const;
  /// Casts `count` rays through a pixel, which is theirs from then on.
  void look_through(const View& view, int x, int y, int count, Tile& tile) const;
  [[nodiscard]] Color shade_pixel(const View& view, std::span<const Sight> sights,
                                  const SceneLight::Occluders& occluders) const;
  [[nodiscard]] const Eigen::Vector3f& corner(int x, int y) const {
    return corners_[static_cast<std::size_t>(y) * (static_cast<std::size_t>(width_) + 1) + static_cast<std::size_t>(x)];
  }
  /// What comes along one ray, over panes and mirrors; slower than a bundle.
  [[nodiscard]] Color look_along(const View& view, const Vector3d& origin, const Vector3d& direction, int meetings,
                                 double way) const;
  [[nodiscard]] Color light_from(const View& view, const Vector3d& origin, const Vector3d& direction, const Hit& hit,
                                 int meetings, double way) const;
  /// By the surface that all of these rays meet, as bright as it is on average; `way` is the length of all the rays'
  /// way from the camera.
  [[nodiscard]] Color scattered(const View& view, std::span<const Sight* const> rays, double way,
                                const SceneLight::Occluders* occluders) const;

  const Scene& scene_;
  const RayCaster& caster_;
  SceneLight light_;
  int width_ = 0;
  int height_ = 0;
  double pixel_rad_ = 0.0;                ///< Width of a pixel in the middle of the image.
  std::vector<Eigen::Vector3f> corners_;  ///< Unit rays through the corners of all pixels; NaN where there is none.
};

}  // namespace rigcal::sim
