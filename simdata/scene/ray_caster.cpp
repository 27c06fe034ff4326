#include "simdata/scene/ray_caster.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace rigcal::sim {

struct RayCaster::BuildItem {
  Eigen::AlignedBox3d box;
  Primitive primitive;
};

namespace {

constexpr int bins = 16;
constexpr std::size_t leaf_size = 2;
constexpr int max_depth = 60;  // the traversal's stack holds one node a level

Eigen::AlignedBox3d box_of(const Flat& flat) {
  const Vector3d half = flat.round ? Vector3d((flat.u.array().square() + flat.v.array().square()).sqrt())
                                   : Vector3d(flat.u.cwiseAbs() + flat.v.cwiseAbs());
  return {flat.center - half, flat.center + half};
}

Eigen::AlignedBox3d box_of(const Cylinder& cylinder) {
  // A circle of radius r across unit axis a reaches r sqrt(1 - a_i^2) along coordinate i.
  const Vector3d half = cylinder.radius * (1.0 - cylinder.axis.array().square()).max(0.0).sqrt().matrix();
  const Vector3d top = cylinder.base + cylinder.length * cylinder.axis;
  Eigen::AlignedBox3d box(cylinder.base.cwiseMin(top) - half, cylinder.base.cwiseMax(top) + half);
  return box;
}

double area_of(const Eigen::AlignedBox3d& box) {
  if (box.isEmpty()) return 0.0;
  const Vector3d size = box.sizes();
  return size.x() * size.y() + size.y() * size.z() + size.z() * size.x();
}

}  // namespace

RayCaster::RayCaster(const Scene& scene)
    : people_(scene.people),
      has_ground_(scene.has_ground),
      ground_height_(scene.ground_height),
      ground_material_(scene.ground_material) {
  std::vector<BuildItem> items;
  items.reserve(scene.flats.size() + scene.cylinders.size());
  for (const Flat& flat : scene.flats) items.push_back({box_of(flat), make_primitive(flat)});
  for (const Cylinder& cylinder : scene.cylinders) items.push_back({box_of(cylinder), make_primitive(cylinder)});
  build(items);
  for (const Material& material : scene.materials) see_through_.push_back(material.glass > 0.0);
}

RayCaster::Primitive RayCaster::make_primitive(const Flat& flat) {
  Primitive primitive;
  primitive.kind = flat.round ? Primitive::Kind::ellipse : Primitive::Kind::rectangle;
  primitive.material = flat.material;
  primitive.center = flat.center;
  const Vector3d cross = flat.u.cross(flat.v);
  primitive.axis = cross.normalized();
  primitive.f1 = flat.v.cross(cross) / cross.squaredNorm();
  primitive.f2 = cross.cross(flat.u) / cross.squaredNorm();
  return primitive;
}

RayCaster::Primitive RayCaster::make_primitive(const Cylinder& cylinder) {
  Primitive primitive;
  primitive.kind = Primitive::Kind::cylinder;
  primitive.material = cylinder.material;
  primitive.center = cylinder.base;
  primitive.axis = cylinder.axis;
  primitive.radius = cylinder.radius;
  primitive.length = cylinder.length;
  primitive.f1 = Vector3d::Zero();
  primitive.f2 = Vector3d::Zero();
  return primitive;
}

bool RayCaster::intersect(const Primitive& primitive, const Vector3d& origin, const Vector3d& direction,
                          double& range) {
  const Vector3d to_center = primitive.center - origin;
  if (primitive.kind != Primitive::Kind::cylinder) {
    const double slope = primitive.axis.dot(direction);
    if (slope == 0.0) return false;
    const double t = primitive.axis.dot(to_center) / slope;
    if (!(t > 0.0 && t < range)) return false;
    const Vector3d p = t * direction - to_center;
    const double a = primitive.f1.dot(p);
    const double b = primitive.f2.dot(p);
    const bool inside =
        primitive.kind == Primitive::Kind::ellipse ? a * a + b * b <= 1.0 : std::abs(a) <= 1.0 && std::abs(b) <= 1.0;
    if (!inside) return false;
    range = t;
    return true;
  }
  // |(o + t d - c) - along axis|^2 = r^2, from the outside only: the nearer root.
  const double d_along = direction.dot(primitive.axis);
  const double c_along = to_center.dot(primitive.axis);
  const Vector3d d_across = direction - d_along * primitive.axis;
  const Vector3d c_across = to_center - c_along * primitive.axis;
  const double a = d_across.squaredNorm();
  if (a < 1e-12) return false;
  const double b = d_across.dot(c_across);
  const double discriminant = b * b - a * (c_across.squaredNorm() - primitive.radius * primitive.radius);
  if (discriminant < 0.0) return false;
  const double t = (b - std::sqrt(discriminant)) / a;
  if (!(t > 0.0 && t < range)) return false;
  const double along = t * d_along - c_along;
  if (along < 0.0 || along > primitive.length) return false;
  range = t;
  return true;
}

Vector3d RayCaster::normal_at(const Primitive& primitive, const Vector3d& point) {
  if (primitive.kind != Primitive::Kind::cylinder) return primitive.axis;
  const Vector3d p = point - primitive.center;
  return (p - p.dot(primitive.axis) * primitive.axis).normalized();
}

void RayCaster::build(std::vector<BuildItem>& items) {
  if (items.empty()) return;
  nodes_.reserve(2 * items.size());
  primitives_.reserve(items.size());
  nodes_.emplace_back();
  split(0, items, 0, items.size(), 0);
  for (const BuildItem& item : items) primitives_.push_back(item.primitive);
}

void RayCaster::split(std::uint32_t node, std::vector<BuildItem>& items, std::size_t begin, std::size_t end,
                      int depth) {
  Eigen::AlignedBox3d box;
  Eigen::AlignedBox3d centers;
  for (std::size_t i = begin; i < end; ++i) {
    box.extend(items[i].box);
    centers.extend(items[i].box.center());
  }
  // Boxes are kept in float, widened by more than its rounding at a kilometre.
  nodes_[node].low = (box.min().array() - 1e-4).cast<float>();
  nodes_[node].high = (box.max().array() + 1e-4).cast<float>();
  const std::size_t count = end - begin;
  nodes_[node].first = static_cast<std::uint32_t>(begin);
  nodes_[node].count = static_cast<std::uint32_t>(count);
  int axis = 0;
  const Vector3d spread = centers.sizes();
  spread.maxCoeff(&axis);
  if (count <= leaf_size || depth >= max_depth || spread[axis] <= 0.0) return;

  const auto bin_of = [&](const BuildItem& item) {
    const double place = (item.box.center()[axis] - centers.min()[axis]) / spread[axis];
    return std::min(bins - 1, static_cast<int>(place * bins));
  };
  std::array<Eigen::AlignedBox3d, bins> bin_box;
  std::array<std::size_t, bins> bin_count{};
  for (std::size_t i = begin; i < end; ++i) {
    const auto bin = static_cast<std::size_t>(bin_of(items[i]));
    bin_box[bin].extend(items[i].box);
    ++bin_count[bin];
  }
  std::array<double, bins> right_cost{};
  Eigen::AlignedBox3d right;
  std::size_t right_count = 0;
  for (std::size_t bin = bins - 1; bin > 0; --bin) {
    right.extend(bin_box[bin]);
    right_count += bin_count[bin];
    right_cost[bin] = area_of(right) * static_cast<double>(right_count);
  }
  Eigen::AlignedBox3d left;
  std::size_t left_count = 0;
  double best = std::numeric_limits<double>::max();
  int best_bin = 0;
  for (std::size_t bin = 0; bin + 1 < bins; ++bin) {
    left.extend(bin_box[bin]);
    left_count += bin_count[bin];
    const double cost = area_of(left) * static_cast<double>(left_count) + right_cost[bin + 1];
    if (left_count > 0 && left_count < count && cost < best) {
      best = cost;
      best_bin = static_cast<int>(bin);
    }
  }
  const auto middle = std::stable_partition(items.begin() + static_cast<std::ptrdiff_t>(begin),
                                            items.begin() + static_cast<std::ptrdiff_t>(end),
                                            [&](const BuildItem& item) { return bin_of(item) <= best_bin; });
  const auto cut = static_cast<std::size_t>(middle - items.begin());
  const auto children = static_cast<std::uint32_t>(nodes_.size());
  nodes_.emplace_back();
  nodes_.emplace_back();
  nodes_[node].first = children;
  nodes_[node].count = 0;
  split(children, items, begin, cut, depth + 1);
  split(children + 1, items, cut, end, depth + 1);
}

int RayCaster::closest_in_tree(const Vector3d& origin, const Vector3d& direction, double& range) const {
  if (nodes_.empty()) return -1;
  const Eigen::Array3f o = origin.array().cast<float>();
  // No component is quite zero, so that zero times infinity cannot arise.
  const auto inverse_of = [](double d) { return static_cast<float>(1.0 / (std::abs(d) < 1e-12 ? 1e-12 : d)); };
  const Eigen::Array3f inverse(inverse_of(direction.x()), inverse_of(direction.y()), inverse_of(direction.z()));
  const auto entry = [&](const Node& node) {
    const Eigen::Array3f t0 = (node.low - o) * inverse;
    const Eigen::Array3f t1 = (node.high - o) * inverse;
    const float near = t0.min(t1).maxCoeff();
    const float far = t0.max(t1).minCoeff();
    return near <= far && far >= 0.0F ? near : std::numeric_limits<float>::infinity();
  };
  struct Waiting {
    std::uint32_t node;
    float entry;
  };
  std::array<Waiting, max_depth + 4> stack;
  std::size_t top = 0;
  stack[top++] = {0, entry(nodes_[0])};
  int found = -1;
  while (top > 0) {
    const Waiting waiting = stack[--top];
    if (!(waiting.entry < static_cast<float>(range) + 1e-3F)) continue;
    const Node& node = nodes_[waiting.node];
    if (node.count > 0) {
      for (std::uint32_t i = node.first; i < node.first + node.count; ++i)
        if (intersect(primitives_[i], origin, direction, range)) found = static_cast<int>(i);
      continue;
    }
    Waiting near{node.first, entry(nodes_[node.first])};
    Waiting far{node.first + 1, entry(nodes_[node.first + 1])};
    if (far.entry < near.entry) std::swap(near, far);
    const float limit = static_cast<float>(range) + 1e-3F;
    if (far.entry < limit) stack[top++] = far;
    if (near.entry < limit) stack[top++] = near;
  }
  return found;
}

RayCaster::People RayCaster::people_at(double time_s) const {
  People bodies;
  bodies.reserve(people_.size());
  for (const Person& person : people_) bodies.push_back(body_at(person, time_s));
  return bodies;
}

std::optional<Hit> RayCaster::finish(const Vector3d& origin, const Vector3d& direction, const People& people,
                                     int primitive, double range, double max_range) const {
  Hit hit;
  bool found = primitive >= 0;
  if (found) {
    const Primitive& nearest = primitives_[static_cast<std::size_t>(primitive)];
    hit.normal = normal_at(nearest, origin + range * direction);
    hit.material = nearest.material;
    hit.surface = primitive;
  }
  if (has_ground_ && direction.z() != 0.0) {
    const double t = (ground_height_ - origin.z()) / direction.z();
    if (t > 0.0 && t < range) {
      range = t;
      hit.normal = Vector3d::UnitZ();
      hit.material = ground_material_;
      hit.surface = ground_surface;
      found = true;
    }
  }
  for (std::size_t person = 0; person < people.size(); ++person) {
    const Body& body = people[person];
    const Vector3d to_center = body.center - origin;
    const double along = to_center.dot(direction);
    if (along < -body.radius || to_center.squaredNorm() - along * along > body.radius * body.radius) continue;
    for (int part = 0; part < Body::parts; ++part) {
      const Primitive limb = make_primitive(body.part[part]);
      if (!intersect(limb, origin, direction, range)) continue;
      hit.normal = normal_at(limb, origin + range * direction);
      hit.material = limb.material;
      hit.surface = people_surface + static_cast<int>(person) * Body::parts + part;
      found = true;
    }
  }
  if (!found || range >= max_range) return std::nullopt;
  hit.range = range;
  if (hit.normal.dot(direction) > 0.0) hit.normal = -hit.normal;
  return hit;
}

std::optional<Hit> RayCaster::cast(const Vector3d& origin, const Vector3d& direction, const People& people,
                                   double max_range) const {
  double range = max_range;
  const int primitive = closest_in_tree(origin, direction, range);
  return finish(origin, direction, people, primitive, range, max_range);
}

std::optional<Hit> RayCaster::cast_by_brute_force(const Vector3d& origin, const Vector3d& direction,
                                                  const People& people, double max_range) const {
  double range = max_range;
  int found = -1;
  for (std::size_t i = 0; i < primitives_.size(); ++i)
    if (intersect(primitives_[i], origin, direction, range)) found = static_cast<int>(i);
  return finish(origin, direction, people, found, range, max_range);
}

}  // namespace rigcal::sim
