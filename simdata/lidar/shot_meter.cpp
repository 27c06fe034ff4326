#include "simdata/lidar/shot_meter.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "simdata/scene/surface_optics.h"
#include "simdata/scene/surface_texture.h"

namespace rigcal::sim {
namespace {

// Livox tag byte: return number in bits 4 and 5, spatial noise of moderate confidence in bits 0 and 1.
constexpr std::uint8_t likely_noise = 0x02;
// A displaced point whose two surfaces are this far apart is noticed by the sensor half of the time (our assumption).
constexpr double noticed_from = 0.1;
// Panes and mirrors that one shot may meet.
constexpr int most_meetings = 6;
// A ray that goes on starts so far behind the surface that it does not meet it again.
constexpr double step = 1e-4;
constexpr double glint_reflectivity = 30.0;

float to_wire_metres(double metres) { return static_cast<float>(std::round(metres * 1e3) * 1e-3); }

std::uint8_t numbered(std::uint8_t tag, int number) {
  return static_cast<std::uint8_t>((static_cast<unsigned>(tag) & 0x0FU) | (static_cast<unsigned>(number) << 4U));
}

}  // namespace

Echo Shot::single(bool nearest) const {
  Echo echo = echoes[nearest ? 0 : static_cast<std::size_t>(strongest)];
  echo.tag = numbered(echo.tag, 1);
  return echo;
}

// The echo's strength falls with the square of the range; at equal strength with the 10 % target at its range, half of
// the shots return.
bool ShotMeter::is_lost(const Surface& surface, Random& random) const {
  const double ratio = noise_.range_at_10_percent / surface.range;
  const double strength = ratio * ratio * (surface.reflectivity / 10.0) * surface.cos_incidence * surface.strength;
  return random.uniform() < noise_.lost_share + 1.0 / (1.0 + strength * strength);
}

// Whether a shot comes back goes by the material's mean: a pattern must not thin the points out.
double ShotMeter::pattern_at(const Material& material, const Hit& hit, const Vector3d& from, const Vector3d& ray,
                             double way, const RayCaster::People& people) const {
  if (material.texture == Texture::plain) return 1.0;
  const Vector3d point = from + hit.range * ray;
  const double beam_rad = std::sqrt(noise_.divergence_y_rad * noise_.divergence_z_rad);
  return look_of(material, {point, hit.normal, caster_.place_on(hit, point, people), hit.surface, way * beam_rad})
      .reflectivity;
}

std::optional<ShotMeter::Surface> ShotMeter::look(const Vector3d& origin, const Vector3d& ray,
                                                  const RayCaster::People& people, Random& random) const {
  const auto hit = caster_.cast(origin, ray, people, noise_.max_range);
  if (!hit) return std::nullopt;
  const Material& material = materials_[static_cast<std::size_t>(hit->material)];
  if (!material.is_plain()) return follow(origin, ray, *hit, people, random);
  if (hit->range < noise_.min_range) return std::nullopt;
  return Surface{hit->range,
                 std::abs(hit->normal.dot(ray)),
                 material.reflectivity,
                 pattern_at(material, *hit, origin, ray, hit->range, people),
                 1.0,
                 0.0};
}

std::optional<ShotMeter::Surface> ShotMeter::follow(const Vector3d& origin, const Vector3d& ray, Hit hit,
                                                    const RayCaster::People& people, Random& random) const {
  Surface surface;
  Vector3d from = origin;
  Vector3d way = ray;
  for (int meeting = 0; meeting < most_meetings; ++meeting) {
    const Material& material = materials_[static_cast<std::size_t>(hit.material)];
    surface.range += hit.range;
    surface.cos_incidence = std::abs(hit.normal.dot(way));
    const Meeting met = material.is_plain() ? Meeting{} : meet(material, surface.cos_incidence, random);
    surface.strength *= met.strength;
    if (met.fate == Fate::gone) return std::nullopt;
    if (met.fate == Fate::scattered || met.fate == Fate::glint) {
      surface.reflectivity = met.fate == Fate::glint ? glint_reflectivity : material.reflectivity;
      if (surface.range < noise_.min_range) return std::nullopt;
      if (met.fate == Fate::scattered) surface.pattern = pattern_at(material, hit, from, way, surface.range, people);
      return surface;
    }
    if (met.glint_besides && surface.pane_range == 0.0 && surface.range >= noise_.min_range)
      surface.pane_range = surface.range;
    const Vector3d point = from + hit.range * way;
    if (met.fate == Fate::reflected) way -= 2.0 * hit.normal.dot(way) * hit.normal;
    from = point + step * way;
    surface.range += step;
    const auto next = caster_.cast(from, way, people, noise_.max_range - surface.range);
    if (!next) return std::nullopt;
    hit = *next;
  }
  return std::nullopt;
}

// A further ray through another part of the footprint. Where it ends on another surface near enough to share the pulse,
// the sensor reports a point between; a surface further apart gives an echo of its own.
void ShotMeter::look_again(const SE3& T_scene_sensor, const Vector3d& direction, const RayCaster::People& people,
                           Random& random, double& center_range, Found& found) const {
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
  const auto surface = look(T_scene_sensor.t, T_scene_sensor.R * second, people, random);
  if (!surface) return;
  const double apart = surface->range - center_range;
  if (std::abs(apart) <= noise_.pulse_length) {
    center_range += random.uniform() * apart;
    Echo& center = found.echoes[0];
    if (std::abs(apart) > noticed_from && random.uniform() < 0.5)
      center.tag = static_cast<std::uint8_t>(center.tag | likely_noise);
    return;
  }
  const auto shares_pulse = [&](const Echo& echo) {
    return std::abs(echo.range - surface->range) <= noise_.pulse_length;
  };
  const auto end = found.echoes.begin() + found.count;
  if (found.count == 3 || std::any_of(found.echoes.begin() + 1, end, shares_pulse)) return;
  if (!is_lost(*surface, random)) finish(found.echoes[static_cast<std::size_t>(found.count++)], *surface, random);
}

void ShotMeter::add_pane(double range, Random& random, Found& found) const {
  finish(found.echoes[static_cast<std::size_t>(found.count++)], {range, 1.0, glint_reflectivity, 1.0, 1.0, 0.0},
         random);
}

void ShotMeter::finish(Echo& echo, const Surface& surface, Random& random) const {
  // Sensors compensate range, and incidence not at all; surfaces here are between matt and shiny.
  const double seen = surface.reflectivity * surface.pattern * surface.strength * (0.4 + 0.6 * surface.cos_incidence);
  const double range = surface.range + noise_.bias_at(seen);
  echo.range = std::max(range + noise_.range_sigma_at(surface.range, surface.cos_incidence) * random.normal(), 1e-3);
  echo.reflectivity = static_cast<std::uint8_t>(std::clamp(std::round(seen + 1.5 * random.normal()), 1.0, 255.0));
}

Shot ShotMeter::measure(const SE3& T_scene_sensor, const Vector3d& direction, const RayCaster::People& people,
                        Random& random) const {
  Shot shot;
  auto center = look(T_scene_sensor.t, T_scene_sensor.R * direction, people, random);
  if (!center) return shot;
  if (is_lost(*center, random)) {
    if (center->pane_range == 0.0) return shot;
    center = Surface{center->pane_range, 1.0, glint_reflectivity, 1.0, 1.0, 0.0};
  }
  Found found;
  found.count = 1;
  if (center->pane_range > 0.0 && center->range - center->pane_range > noise_.pulse_length)
    add_pane(center->pane_range, random, found);
  if (noise_.second_ray_share > 0.0 && random.uniform() < noise_.second_ray_share) {
    for (int i = 0; i < extra_looks_; ++i) look_again(T_scene_sensor, direction, people, random, center->range, found);
  }
  finish(found.echoes[0], *center, random);

  shot.echoes = found.echoes;
  shot.count = found.count;
  const double center_range = found.echoes[0].range;
  std::sort(shot.echoes.begin(), shot.echoes.begin() + shot.count,
            [](const Echo& a, const Echo& b) { return a.range < b.range; });
  for (int i = 0; i < shot.count; ++i) {
    Echo& echo = shot.echoes[static_cast<std::size_t>(i)];
    echo.tag = numbered(echo.tag, i + 1);
    if (echo.range == center_range) shot.strongest = i;
  }
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
