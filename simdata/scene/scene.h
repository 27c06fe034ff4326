#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "core/geometry/se3.h"

/// What the simulated sensors look at: metres, z up, nothing but real surfaces (no texture stands for relief).
namespace rigcal::sim {

/// What is painted on a surface, see surface_texture.h.
enum class Texture {
  plain,
  brick,
  plaster,
  concrete,
  stone,
  paving,
  tiles,
  boards,
  grass,
  leaves,
  window,
  bars,
  cloth,
  carton,
  metal,
  checker,
};

/// How a surface answers the laser, and what it looks like.
struct Material {
  std::string name;
  double reflectivity = 40.0;  ///< 0 .. 100 of a Lambertian target, up to 150 for brighter ones (protocol scale).
  /// What is not scattered; at most one of them, see surface_optics.h. Shares, 0 .. 1.
  double glass = 0.0;   ///< Of the light that goes through a pane.
  double mirror = 0.0;  ///< That a mirror reflects.
  double wet = 0.0;     ///< Of the surface that is under water.

  Texture texture = Texture::plain;
  double pattern_m = 0.0;  ///< Size of the texture's bricks, boards or squares; 0: what is usual.
  Eigen::Array3f color = Eigen::Array3f::Constant(0.4F);  ///< Share of red, green and blue light that it scatters.

  [[nodiscard]] bool is_plain() const { return glass == 0.0 && mirror == 0.0 && wet == 0.0; }
};

/// A flat rectangle (or parallelogram), or the ellipse inside it: the points center + a u + b v with |a|, |b| <= 1,
/// or a^2 + b^2 <= 1. Seen from both sides.
struct Flat {
  Vector3d center = Vector3d::Zero();
  Vector3d u = Vector3d::UnitX();
  Vector3d v = Vector3d::UnitY();
  bool round = false;
  int material = 0;
};

/// The side of a cylinder from `base` to base + length * axis; its ends are Flats where they can be seen.
struct Cylinder {
  Vector3d base = Vector3d::Zero();
  Vector3d axis = Vector3d::UnitZ();  ///< Unit length.
  double length = 1.0;
  double radius = 0.1;
  int material = 0;
};

/// Somebody who walks along `path` and back again, for ever, at constant speed.
struct Person {
  std::vector<Vector3d> path;  ///< Positions of the feet; two at least.
  double speed_m_s = 1.2;
  double start_m = 0.0;  ///< Place on the path at time 0.
  double height = 1.75;
  int material = 0;
};

/// A lamp in one point, as bright in all directions.
struct Lamp {
  Vector3d position = Vector3d::Zero();
  double strength = 1.0;  ///< Irradiance 1 m away.
};

/// The light in which cameras see a scene. Irradiance 1 on a white surface fills a camera's pixels in 5 ms at 0 dB.
struct Light {
  double sun_azimuth_rad = to_rad(215.0);   ///< Where the sun stands: from x towards y,
  double sun_elevation_rad = to_rad(38.0);  ///< and above the horizon.
  double sun = 0.85;                        ///< Irradiance across its rays.
  double ambient = 0.3;                     ///< From everywhere, most of it from above.
  std::vector<Lamp> lamps;

  [[nodiscard]] Vector3d to_sun() const;  ///< Unit.
};

/// A scene, flattened into primitives. Make one with the functions of scene_shapes.h or load_scene().
struct Scene {
  std::string name;
  std::vector<Material> materials;
  std::vector<Flat> flats;
  std::vector<Cylinder> cylinders;
  std::vector<Person> people;
  bool has_ground = false;  ///< An endless plane z = ground_height.
  double ground_height = 0.0;
  int ground_material = 0;
  Light light;
  /// Where the turntable stands: origin on the table's axis at the height of the base sensor, x to the first stop.
  SE3 T_scene_table;
};

/// The limbs of one person at a time (s): four cylinders (two legs, trunk, head), and the circle that holds all.
struct Body {
  static constexpr int parts = 4;
  Cylinder part[parts];
  Vector3d center = Vector3d::Zero();  ///< Of the bounding sphere.
  double radius = 0.0;
};
[[nodiscard]] Body body_at(const Person& person, double time_s);

}  // namespace rigcal::sim
