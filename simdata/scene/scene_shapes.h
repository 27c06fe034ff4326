#pragma once

#include <array>
#include <cstdint>

#include "simdata/scene/scene.h"

/// The building blocks of scenes: each adds its primitives to a Scene. Metres; materials by index.
namespace rigcal::sim {

/// A box of `size` about T's origin, all six faces.
void add_box(Scene& scene, const SE3& T_scene_box, const Vector3d& size, int material);

/// A rectangle of size x by y in the xy plane of T.
void add_rectangle(Scene& scene, const SE3& T_scene_flat, double size_x, double size_y, int material);

/// A cylinder with both ends closed.
void add_cylinder(Scene& scene, const Cylinder& cylinder);

/// Windows of a facade: `count` columns and `rows` rows, evenly spread, set back by `recess` behind the wall.
struct Windows {
  int count = 0;
  int rows = 1;
  double width = 1.2;
  double height = 1.4;
  double sill = 0.9;       ///< From the foot of the wall to the first row.
  double row_pitch = 3.0;  ///< From row to row.
  double recess = 0.15;
  int material = 0;
};

/// An upright wall from `from` to `to` (feet at their z, which is equal), its outside to the right of the way from
/// `from` to `to`, with recessed windows: wall strips, window panes and the four reveals of each window.
void add_facade(Scene& scene, const Vector3d& from, const Vector3d& to, double height, const Windows& windows,
                int material);

/// `steps` steps, the first at T's origin, going up along x by `rise` each `tread`, `width` wide along y.
void add_stairs(Scene& scene, const SE3& T_scene_stairs, int steps, double rise, double tread, double width,
                int material);

/// Leaves: `count` small ellipses of random place in the ellipsoid of half axes `radii`, random direction and
/// half axes between size[0] and size[1].
void add_foliage(Scene& scene, const Vector3d& center, const Vector3d& radii, int count, std::array<double, 2> size,
                 std::uint64_t seed, int material);

/// Stones: `count` boxes of random turn, with half axes between size[0] and size[1], half sunk into the ground of
/// height `z` in the rectangle from (x0, y0) to (x1, y1).
void add_rocks(Scene& scene, const std::array<double, 4>& area, double z, int count, std::array<double, 2> size,
               std::uint64_t seed, int material);

}  // namespace rigcal::sim
