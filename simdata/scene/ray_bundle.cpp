// Bundles of rays through the ray caster's tree, and shadows.
#include <algorithm>
#include <array>
#include <cmath>

#include "simdata/scene/ray_caster.h"

namespace rigcal::sim {
namespace {

// The way t of origin + t direction at which a bundle can be in a box: for each axis and each side of the box a bound
// that is linear in t, for the origin and the direction that reach it most easily.
struct BundleBounds {
  std::array<float, 6> slope{};  // the bound: start + slope t >= edge of the box, in the side's own direction
  std::array<float, 6> start{};

  explicit BundleBounds(const RayBundle& bundle) {
    for (int axis = 0; axis < 3; ++axis) {
      const auto k = static_cast<std::size_t>(axis);
      slope[k] = static_cast<float>(bundle.directions.max()[axis]);
      start[k] = static_cast<float>(bundle.origins.max()[axis]);
      slope[k + 3] = static_cast<float>(-bundle.directions.min()[axis]);
      start[k + 3] = static_cast<float>(-bundle.origins.min()[axis]);
    }
  }

  // First t in [0, reach] at which the box may be met; infinity where there is none.
  [[nodiscard]] float entry(const Eigen::Array3f& low, const Eigen::Array3f& high, float reach) const {
    float first = 0.0F;
    float last = reach;
    for (std::size_t k = 0; k < 6; ++k) {
      // Above the low edge, or below the high one.
      const auto axis = static_cast<Eigen::Index>(k % 3);
      const float gap = (k < 3 ? low[axis] : -high[axis]) - start[k];
      if (slope[k] > 0.0F) {
        first = std::max(first, gap / slope[k]);
      } else if (slope[k] < 0.0F) {
        last = std::min(last, gap / slope[k]);
      } else if (gap > 0.0F) {
        return std::numeric_limits<float>::infinity();
      }
    }
    // Wider than the rounding of the divisions.
    return first <= last * 1.00001F + 1e-4F ? first : std::numeric_limits<float>::infinity();
  }
};

}  // namespace

bool RayCaster::gather(const RayBundle& bundle, std::size_t most, std::vector<Candidate>& candidates) const {
  candidates.clear();
  if (nodes_.empty()) return true;
  const BundleBounds bounds(bundle);
  const auto reach = static_cast<float>(std::min(bundle.reach, 1e9));
  std::array<std::uint32_t, 128> stack;  // two a level
  std::size_t top = 0;
  stack[top++] = 0;
  while (top > 0) {
    const Node& node = nodes_[stack[--top]];
    const float entry = bounds.entry(node.low, node.high, reach);
    if (!std::isfinite(entry)) continue;
    if (node.count == 0) {
      stack[top++] = node.first;
      stack[top++] = node.first + 1;
      continue;
    }
    if (candidates.size() + node.count > most) return false;
    for (std::uint32_t i = node.first; i < node.first + node.count; ++i) candidates.push_back({i, entry});
  }
  std::sort(candidates.begin(), candidates.end(), [](const Candidate& a, const Candidate& b) {
    return a.entry != b.entry ? a.entry < b.entry : a.primitive < b.primitive;
  });
  return true;
}

std::optional<Hit> RayCaster::cast_among(const std::vector<Candidate>& candidates, const Vector3d& origin,
                                         const Vector3d& direction, const People& people, double max_range) const {
  double range = max_range;
  int found = -1;
  for (const Candidate& candidate : candidates) {
    if (candidate.entry > static_cast<float>(range) + 1e-3F) break;
    if (intersect(primitives_[candidate.primitive], origin, direction, range))
      found = static_cast<int>(candidate.primitive);
  }
  return finish(origin, direction, people, found, range, max_range);
}

bool RayCaster::blocks(const Primitive& primitive, const Vector3d& origin, const Vector3d& direction) const {
  double way = 1.0;
  return !see_through_[static_cast<std::size_t>(primitive.material)] && intersect(primitive, origin, direction, way);
}

bool RayCaster::people_block(const Vector3d& origin, const Vector3d& direction, const People& people) {
  const double square = direction.squaredNorm();
  for (const Body& body : people) {
    const Vector3d to_center = body.center - origin;
    const double along = std::clamp(to_center.dot(direction) / square, 0.0, 1.0);
    if ((to_center - along * direction).squaredNorm() > body.radius * body.radius) continue;
    for (const Cylinder& part : body.part) {
      double way = 1.0;
      if (intersect(make_primitive(part), origin, direction, way)) return true;
    }
  }
  return false;
}

bool RayCaster::is_blocked_among(const std::vector<Candidate>& candidates, const Vector3d& origin,
                                 const Vector3d& direction, const People& people) const {
  for (const Candidate& candidate : candidates)
    if (blocks(primitives_[candidate.primitive], origin, direction)) return true;
  return people_block(origin, direction, people);
}

bool RayCaster::is_blocked(const Vector3d& origin, const Vector3d& direction, const People& people) const {
  if (people_block(origin, direction, people)) return true;
  if (nodes_.empty()) return false;
  const RayBundle one{{origin, origin}, {direction, direction}, 1.0};
  const BundleBounds bounds(one);
  std::array<std::uint32_t, 128> stack;
  std::size_t top = 0;
  stack[top++] = 0;
  while (top > 0) {
    const Node& node = nodes_[stack[--top]];
    if (!std::isfinite(bounds.entry(node.low, node.high, 1.0F))) continue;
    if (node.count == 0) {
      stack[top++] = node.first;
      stack[top++] = node.first + 1;
      continue;
    }
    for (std::uint32_t i = node.first; i < node.first + node.count; ++i)
      if (blocks(primitives_[i], origin, direction)) return true;
  }
  return false;
}

SurfacePlace RayCaster::place_on(const Hit& hit, const Vector3d& point, const People& people) const {
  SurfacePlace place;
  if (hit.surface == ground_surface) {
    place.at = point.head<2>();
    return place;
  }
  const bool is_limb = hit.surface >= people_surface;
  const auto limb = static_cast<std::size_t>(hit.surface - people_surface);
  const Primitive& surface = is_limb ? make_primitive(people[limb / Body::parts].part[limb % Body::parts])
                                     : primitives_[static_cast<std::size_t>(hit.surface)];
  const Vector3d p = point - surface.center;
  if (surface.kind != Primitive::Kind::cylinder) {
    // f1 and f2 are dual to the half edges u and v: they give shares of them.
    const Vector3d cross = surface.f1.cross(surface.f2);
    place.half = {surface.f2.norm() / cross.norm(), surface.f1.norm() / cross.norm()};
    place.at = place.half.cwiseProduct(Eigen::Vector2d(surface.f1.dot(p), surface.f2.dot(p)));
    return place;
  }
  const Vector3d x = surface.axis.unitOrthogonal();
  const double angle = std::atan2(surface.axis.cross(x).dot(p), x.dot(p));
  place.at = {angle * surface.radius, surface.axis.dot(p) - 0.5 * surface.length};
  place.half = {pi * surface.radius, 0.5 * surface.length};
  return place;
}

}  // namespace rigcal::sim
