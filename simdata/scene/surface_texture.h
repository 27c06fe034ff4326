#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "simdata/scene/ray_caster.h"
#include "simdata/scene/scene.h"

/// What is painted on surfaces: edges that are no geometry.
namespace rigcal::sim {

/// A place on a surface and how much of it is looked at.
struct SurfacePoint {
  Vector3d p = Vector3d::Zero();        ///< In the scene.
  Vector3d normal = Vector3d::UnitZ();  ///< Towards the observer, unit.
  SurfacePlace place;                   ///< On its own surface.
  int surface = 0;                      ///< Hit::surface: leaves and clothes differ from one to the next.
  double footprint = 0.0;               ///< Metres across, of a pixel or a beam.
};

/// What a camera and a LiDAR see there.
struct Look {
  Eigen::Array3f color;       ///< Share of red, green and blue light that is scattered.
  double reflectivity = 1.0;  ///< At 905 nm, in units of the material's: its mean over the pattern is near 1.
  double mirrored = 0.0;      ///< Share of the sky that a pane throws back, head on.
};

/// The texture of a material at a point. Colour and reflectivity follow the same pattern, but not alike: a red brick
/// and its grey joint, or a green leaf and a brown one, differ less at 905 nm than to the eye; print and dye hardly
/// show; soot and shade of single bricks show in part.
[[nodiscard]] Look look_of(const Material& material, const SurfacePoint& point);

/// The name of a texture in scene files.
[[nodiscard]] std::optional<Texture> parse_texture(std::string_view name);
[[nodiscard]] std::vector<std::string> texture_names();

}  // namespace rigcal::sim
