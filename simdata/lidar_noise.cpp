#include "simdata/lidar_noise.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace rigcal::sim {
namespace {

// Livox tag byte: return number in bits 4 and 5, spatial noise of moderate confidence in bits 0 and 1.
constexpr std::uint8_t first_return = 0x10;
constexpr std::uint8_t second_return = 0x20;
constexpr std::uint8_t likely_noise = 0x02;
// A displaced point whose two surfaces are this far apart is noticed by the sensor half of the time (our assumption).
constexpr double noticed_from = 0.1;

float to_wire_metres(double metres) { return static_cast<float>(std::round(metres * 1e3) * 1e-3); }

}  // namespace

LidarNoise LidarNoise::avia() {
  LidarNoise noise;
  noise.angle_sigma_rad = to_rad(0.02);
  noise.divergence_y_rad = to_rad(0.03);
  noise.divergence_z_rad = to_rad(0.28);
  return noise;
}

LidarNoise LidarNoise::mid40() {
  LidarNoise noise = avia();
  noise.angle_sigma_rad = to_rad(0.03);
  noise.max_range = 260.0;
  noise.range_at_10_percent = 90.0;
  return noise;
}

LidarNoise LidarNoise::none() {
  LidarNoise noise;
  noise.range_sigma = noise.range_sigma_per_m = noise.range_sigma_max = 0.0;
  noise.min_range = 0.0;
  noise.lost_share = 0.0;
  noise.range_at_10_percent = 1e9;
  noise.second_ray_share = 0.0;
  return noise;
}

double LidarNoise::range_sigma_at(double range, double cos_incidence) const {
  const double straight = std::min(range_sigma + range_sigma_per_m * range, range_sigma_max);
  return straight * (1.0 + 0.3 * (1.0 - cos_incidence));
}

// The echo's strength falls with the square of the range; at equal strength with the 10 % target at its range, half of
// the shots return.
bool ShotMeter::is_lost(double range, double cos_incidence, double reflectivity, Random& random) const {
  const double ratio = noise_.range_at_10_percent / range;
  const double strength = ratio * ratio * (reflectivity / 10.0) * cos_incidence;
  return random.uniform() < noise_.lost_share + 1.0 / (1.0 + strength * strength);
}

// A second ray through another part of the footprint. Where it ends on another surface near enough to share the pulse,
// the sensor reports a point between; a surface further apart gives an echo of its own.
void ShotMeter::look_again(const SE3& T_scene_sensor, const Vector3d& direction, const RayCaster::People& people,
                           Random& random, double& first_range, Shot& shot) const {
  double a = 0.0;
  double b = 0.0;
  do {
    a = random.uniform(-1.0, 1.0);
    b = random.uniform(-1.0, 1.0);
  } while (a * a + b * b > 1.0);
  const Vector3d left = Vector3d::UnitZ().cross(direction).normalized();
  const Vector3d up = direction.cross(left);
  const Vector3d second =
      (direction + 0.5 * noise_.divergence_y_rad * a * left + 0.5 * noise_.divergence_z_rad * b * up).normalized();
  const Vector3d ray = T_scene_sensor.R * second;
  const auto hit = caster_.cast(T_scene_sensor.t, ray, people, noise_.max_range);
  if (!hit || hit->range < noise_.min_range) return;
  const double apart = hit->range - first_range;
  if (std::abs(apart) > noise_.pulse_length) {
    const double cos_incidence = std::abs(hit->normal.dot(ray));
    const double reflectivity = materials_[static_cast<std::size_t>(hit->material)].reflectivity;
    if (is_lost(hit->range, cos_incidence, reflectivity, random)) return;
    shot.second.tag = second_return;
    finish(shot.second, hit->range, cos_incidence, reflectivity, random);
    return;
  }
  first_range += random.uniform() * apart;
  if (std::abs(apart) > noticed_from && random.uniform() < 0.5)
    shot.first.tag = static_cast<std::uint8_t>(shot.first.tag | likely_noise);
}

void ShotMeter::finish(Echo& echo, double range, double cos_incidence, double reflectivity, Random& random) const {
  echo.range = std::max(range + noise_.range_sigma_at(range, cos_incidence) * random.normal(), 1e-3);
  // Sensors compensate range, and incidence not at all; surfaces here are between matt and shiny.
  const double seen = reflectivity * (0.4 + 0.6 * cos_incidence) + 1.5 * random.normal();
  echo.reflectivity = static_cast<std::uint8_t>(std::clamp(std::round(seen), 1.0, 255.0));
}

Shot ShotMeter::measure(const SE3& T_scene_sensor, const Vector3d& direction, const RayCaster::People& people,
                        Random& random) const {
  Shot shot;
  const Vector3d ray = T_scene_sensor.R * direction;
  const auto hit = caster_.cast(T_scene_sensor.t, ray, people, noise_.max_range);
  if (!hit || hit->range < noise_.min_range) return shot;
  const double cos_incidence = std::abs(hit->normal.dot(ray));
  const double reflectivity = materials_[static_cast<std::size_t>(hit->material)].reflectivity;
  if (is_lost(hit->range, cos_incidence, reflectivity, random)) return shot;

  shot.first.tag = first_return;
  double range = hit->range;
  if (noise_.second_ray_share > 0.0 && random.uniform() < noise_.second_ray_share)
    look_again(T_scene_sensor, direction, people, random, range, shot);
  finish(shot.first, range, cos_incidence, reflectivity, random);
  shot.direction = direction;
  if (noise_.angle_sigma_rad > 0.0) {
    const Vector3d left = Vector3d(-direction.y(), direction.x(), 0.0).normalized();
    const Vector3d up = direction.cross(left);
    const double sideways = random.normal();
    const double upwards = random.normal();
    shot.direction += noise_.angle_sigma_rad * (sideways * left + upwards * up);
    shot.direction.normalize();
  }
  return shot;
}

Point to_point(const Vector3d& direction, const Echo& echo) {
  const Vector3d p = echo.range * direction;
  Point point;
  point.x = to_wire_metres(p.x());
  point.y = to_wire_metres(p.y());
  point.z = to_wire_metres(p.z());
  point.reflectivity = echo.reflectivity;
  point.tag = echo.tag;
  return point;
}

}  // namespace rigcal::sim
