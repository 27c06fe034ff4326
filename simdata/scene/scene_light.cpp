#include "simdata/scene/scene_light.h"

#include <algorithm>
#include <cmath>

#include "simdata/scene/pattern_noise.h"

namespace rigcal::sim {
namespace {

// Nothing of a scene is so far up that a longer shadow could matter.
constexpr double sun_way = 300.0;
// A shadow ray starts so far above its surface that it does not meet it.
constexpr double lift = 2e-3;
constexpr std::size_t most_occluders = 96;

const Color sun_color{1.0F, 0.96F, 0.88F};
const Color sky_color{0.88F, 0.96F, 1.1F};
const Color lamp_color{1.0F, 0.97F, 0.9F};

}  // namespace

SceneLight::SceneLight(const Light& light, const RayCaster& caster)
    : light_(light), caster_(caster), to_sun_(light.to_sun()) {}

Vector3d SceneLight::way_to(std::size_t source, const Vector3d& point) const {
  if (source == 0) return sun_way * to_sun_;
  return light_.lamps[source - 1].position - point;
}

void SceneLight::gather(const Eigen::AlignedBox3d& points, Occluders& occluders) const {
  Eigen::AlignedBox3d origins(points.min().array() - lift, points.max().array() + lift);
  for (std::size_t source = light_.sun > 0.0 ? 0 : 1; source < source_count(); ++source) {
    RayBundle bundle{origins, {}, 1.0};
    bundle.directions.extend(way_to(source, origins.min()));
    bundle.directions.extend(way_to(source, origins.max()));
    // Rays to a lamp start together there: a narrower bundle, and the same surfaces.
    if (source > 0) {
      const Vector3d lamp = light_.lamps[source - 1].position;
      bundle = {{lamp, lamp}, {origins.min() - lamp, origins.max() - lamp}, 1.0};
    }
    auto& found = occluders.sources[source];
    found.by_tree = !caster_.gather(bundle, most_occluders, found.candidates);
  }
}

bool SceneLight::reaches(std::size_t source, const Vector3d& point, const Vector3d& normal,
                         const RayCaster::People& people, const Occluders* occluders) const {
  const Vector3d from = point + lift * normal;
  const Vector3d way = way_to(source, from);
  if (occluders == nullptr || occluders->sources[source].by_tree) return !caster_.is_blocked(from, way, people);
  return !caster_.is_blocked_among(occluders->sources[source].candidates, from, way, people);
}

Color SceneLight::direct(std::size_t source, const Vector3d& point, const Vector3d& normal, bool thin) const {
  const Vector3d way = way_to(source, point);
  const double square = way.squaredNorm();
  double slope = normal.dot(way) / std::sqrt(square);
  if (slope < 0.0) slope = thin ? -0.45 * slope : 0.0;
  if (source == 0) return sun_color * static_cast<float>(light_.sun * slope);
  return lamp_color * static_cast<float>(light_.lamps[source - 1].strength * slope / std::max(square, 0.01));
}

Color SceneLight::ambient(const Vector3d& normal) const {
  // More from above than from below, more from where the sun is.
  const double share = 0.68 + 0.32 * normal.z() + 0.14 * normal.dot(to_sun_);
  return sky_color * static_cast<float>(light_.ambient * share);
}

Color SceneLight::sky(const Vector3d& direction) const {
  const Color zenith{0.55F, 0.8F, 1.35F};
  const Color horizon{1.15F, 1.25F, 1.35F};
  const Color haze{0.5F, 0.5F, 0.48F};
  const double height = std::max(0.0, direction.z());
  const auto up = static_cast<float>(std::sqrt(height));
  const Color clear = horizon + up * (zenith - horizon);
  // Clouds on a sheet far above.
  const Vector3d sheet = direction / (height + 0.15);
  const double cloud = smooth_noise(sheet, 0.9, 0.0) + 0.5 * smooth_noise(sheet, 0.35, 0.0) - 0.1;
  const auto white = static_cast<float>(std::clamp(1.2 * cloud, 0.0, 0.9));
  const Color above = 1.6F * (clear + white * (Color::Constant(2.1F) - clear));
  // The horizon is no sharp line.
  const auto share = static_cast<float>(std::clamp(0.5 + direction.z() / 0.05, 0.0, 1.0));
  return (haze + share * (above - haze)) * static_cast<float>(light_.ambient);
}

}  // namespace rigcal::sim
