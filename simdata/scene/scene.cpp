#include "simdata/scene/scene.h"

#include <Eigen/Geometry>
#include <cmath>

namespace rigcal::sim {
namespace {

struct Walk {
  Vector3d feet;
  Vector3d heading;
};

// There and back along the path: the place is a triangle wave of the way gone.
Walk walk_at(const Person& person, double way) {
  double length = 0.0;
  for (std::size_t i = 1; i < person.path.size(); ++i) length += (person.path[i] - person.path[i - 1]).norm();
  double place = std::fmod(way, 2.0 * length);
  if (place < 0.0) place += 2.0 * length;
  const bool back = place > length;
  if (back) place = 2.0 * length - place;
  std::size_t leg = 1;
  while (leg + 1 < person.path.size()) {
    const double leg_length = (person.path[leg] - person.path[leg - 1]).norm();
    if (place <= leg_length) break;
    place -= leg_length;
    ++leg;
  }
  const Vector3d heading = (person.path[leg] - person.path[leg - 1]).normalized();
  return {person.path[leg - 1] + place * heading, back ? Vector3d(-heading) : heading};
}

}  // namespace

Vector3d Light::to_sun() const {
  const double level = std::cos(sun_elevation_rad);
  return {level * std::cos(sun_azimuth_rad), level * std::sin(sun_azimuth_rad), std::sin(sun_elevation_rad)};
}

Body body_at(const Person& person, double time_s) {
  const double way = person.start_m + person.speed_m_s * time_s;
  const auto [feet, heading] = walk_at(person, way);
  const double h = person.height;
  const Vector3d side = Vector3d::UnitZ().cross(heading);
  const double hip = 0.48 * h;
  // A double step is about 0.85 body heights; the legs swing half a step each way.
  const double swing = 0.45 * std::sin(2.0 * pi * way / (0.85 * h));
  Body body;
  for (int leg = 0; leg < 2; ++leg) {
    const double angle = leg == 0 ? swing : -swing;
    const Vector3d down = -std::cos(angle) * Vector3d::UnitZ() + std::sin(angle) * heading;
    const Vector3d hip_joint = feet + hip * Vector3d::UnitZ() + (leg == 0 ? 0.1 : -0.1) * side;
    body.part[leg] = {hip_joint, down, hip / std::cos(angle) * 0.97, 0.045 * h, person.material};
  }
  body.part[2] = {feet + hip * Vector3d::UnitZ(), Vector3d::UnitZ(), 0.36 * h, 0.105 * h, person.material};
  body.part[3] = {feet + 0.87 * h * Vector3d::UnitZ(), Vector3d::UnitZ(), 0.13 * h, 0.055 * h, person.material};
  body.center = feet + 0.5 * h * Vector3d::UnitZ();
  body.radius = 0.62 * h;
  return body;
}

}  // namespace rigcal::sim
