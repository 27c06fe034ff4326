#include "core/planes/merge_planes.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <numeric>

#include "core/base/wide.h"
#include "core/geometry/symmetric_eigen.h"

namespace rigcal {
namespace {

constexpr double max_normal_angle_rad = to_rad(3.0);
constexpr double block_m = 2.0;            // Unevenness is taken as one over blocks of this size.
constexpr double min_flatness_m = 0.0005;  // No wall is flatter.
constexpr double max_extent_m = 40.0;

struct Plane {
  Vector3d center;
  Vector3d normal;
};

double information(const PlaneFeature& leaf) {
  double sum = 0.0;
  for (const PlaneObservation& o : leaf.observations) sum += 1.0 / o.offset_variance;
  return sum;
}

// Coordinates of some middles and normals.
struct Columns {
  std::array<const double*, 3> center;
  std::array<const double*, 3> normal;
};

// A disc, as thick as its tolerance.
struct Bounds {
  std::array<double, 3> normal;
  std::array<double, 3> origin;
  double offset;
  double min_cosine;
  double tolerance_m;
  double radius2;
};

// Whether there is any within; `hit` tells which.
RIGCAL_WIDE bool mark(const Columns& at, std::size_t count, const Bounds& o, std::int64_t* hit) {
  std::int64_t any = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const double cosine = at.normal[0][i] * o.normal[0] + at.normal[1][i] * o.normal[1] + at.normal[2][i] * o.normal[2];
    const double off =
        at.center[0][i] * o.normal[0] + at.center[1][i] * o.normal[1] + at.center[2][i] * o.normal[2] - o.offset;
    const double dx = at.center[0][i] - o.origin[0];
    const double dy = at.center[1][i] - o.origin[1];
    const double dz = at.center[2][i] - o.origin[2];
    const std::int64_t within = (std::abs(cosine) >= o.min_cosine) & (std::abs(off) <= o.tolerance_m) &
                                (dx * dx + dy * dy + dz * dz <= o.radius2);
    hit[i] = within;
    any |= within;
  }
  return any != 0;
}

// Holds the middles of some leaves that follow each other.
struct Box {
  std::array<double, 3> middle{};
  std::array<double, 3> half{};

  // Whether none of them can lie within; a micrometre is more than rounding ever is.
  [[nodiscard]] bool is_beyond(const Bounds& o) const {
    double off = -o.offset;
    double reach = o.tolerance_m + 1e-6;
    double apart2 = 0.0;
    for (std::size_t k = 0; k < 3; ++k) {
      off += middle[k] * o.normal[k];
      reach += half[k] * std::abs(o.normal[k]);
      const double gap = std::max(0.0, std::abs(middle[k] - o.origin[k]) - half[k] - 1e-6);
      apart2 += gap * gap;
    }
    return std::abs(off) > reach || apart2 > o.radius2;
  }
};

// Middles and normals of the leaves that belong to no plane yet, each coordinate by itself: they are gone through for
// every seed and radius. Leaves come voxel by voxel, so that a block of them lies together and can be passed over.
class FreeLeaves {
 public:
  explicit FreeLeaves(const std::vector<PlaneFeature>& leaves) : number_(leaves.size()) {
    std::iota(number_.begin(), number_.end(), std::size_t{0});
    for (std::size_t k = 0; k < 3; ++k) {
      for (const PlaneFeature& leaf : leaves) {
        center_[k].push_back(leaf.center_G[static_cast<Eigen::Index>(k)]);
        normal_[k].push_back(leaf.normal_G[static_cast<Eigen::Index>(k)]);
      }
    }
    set_boxes();
  }

  void leave_out(const std::vector<char>& taken) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < number_.size(); ++i) {
      if (taken[number_[i]]) continue;
      number_[kept] = number_[i];
      for (std::size_t k = 0; k < 3; ++k) {
        center_[k][kept] = center_[k][i];
        normal_[k][kept] = normal_[k][i];
      }
      ++kept;
    }
    number_.resize(kept);
    set_boxes();
  }

  // Those on a plane within `radius` of `origin`, in the order of their numbers.
  [[nodiscard]] std::vector<std::size_t> near(const Plane& plane, const Vector3d& origin, double radius,
                                              double min_cosine, double tolerance_m) const {
    std::vector<std::size_t> out;
    std::array<std::int64_t, block> hit{};
    const Bounds bounds{{plane.normal.x(), plane.normal.y(), plane.normal.z()},
                        {origin.x(), origin.y(), origin.z()},
                        plane.normal.dot(plane.center),
                        min_cosine,
                        tolerance_m,
                        radius * radius};
    for (std::size_t begin = 0; begin < number_.size(); begin += block) {
      if (boxes_[begin / block].is_beyond(bounds)) continue;
      const std::size_t count = std::min(block, number_.size() - begin);
      const Columns at{{&center_[0][begin], &center_[1][begin], &center_[2][begin]},
                       {&normal_[0][begin], &normal_[1][begin], &normal_[2][begin]}};
      if (!mark(at, count, bounds, hit.data())) continue;
      for (std::size_t i = 0; i < count; ++i) {
        if (hit[i] != 0) out.push_back(number_[begin + i]);
      }
    }
    return out;
  }

 private:
  static constexpr std::size_t block = 32;

  void set_boxes() {
    boxes_.clear();
    for (std::size_t begin = 0; begin < number_.size(); begin += block) {
      const auto end = static_cast<std::ptrdiff_t>(std::min(begin + block, number_.size()));
      Box& box = boxes_.emplace_back();
      for (std::size_t k = 0; k < 3; ++k) {
        const auto [low, high] =
            std::minmax_element(center_[k].begin() + static_cast<std::ptrdiff_t>(begin), center_[k].begin() + end);
        box.middle[k] = 0.5 * (*low + *high);
        box.half[k] = 0.5 * (*high - *low);
      }
    }
  }

  std::vector<std::size_t> number_;
  std::array<std::vector<double>, 3> center_;
  std::array<std::vector<double>, 3> normal_;
  std::vector<Box> boxes_;
};

// How much farther out is looked with each step.
constexpr double growth = 1.6;

class Merger {
 public:
  Merger(std::vector<PlaneFeature>& leaves, const MergeOptions& options)
      : leaves_(leaves), options_(options), taken_(leaves.size(), 0), free_(leaves) {
    for (const PlaneFeature& leaf : leaves) information_.push_back(information(leaf));
  }

  std::vector<PlaneFeature> run() {
    std::vector<std::size_t> order(leaves_.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    // The largest and best seen first: their normals are worth most.
    const auto rank = [&](std::size_t i) { return information_[i] * leaves_[i].size_m * leaves_[i].size_m; };
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return rank(a) > rank(b); });
    std::vector<PlaneFeature> merged;
    for (const std::size_t seed : order) {
      if (taken_[seed]) continue;
      Plane plane{leaves_[seed].center_G, leaves_[seed].normal_G};
      const std::vector<std::size_t> members = grow(seed, plane);
      if (members.size() < 4) continue;
      for (const std::size_t i : members) taken_[i] = 1;
      free_.leave_out(taken_);
      merged.push_back(merge(members, plane));
    }
    return merged;
  }

 private:
  // Farther and farther out, so that the tilt of the first small piece does not decide.
  std::vector<std::size_t> grow(std::size_t seed, Plane& plane) const {
    const Vector3d origin = leaves_[seed].center_G;
    double radius = 2.0 * leaves_[seed].size_m;
    double farthest = radius;
    while (farthest < max_extent_m) farthest *= growth;
    // The plane stays as it is until three are near: those of all radii up to there are among these, and most seeds
    // have no more.
    const std::vector<std::size_t> reach = inliers(plane, origin, farthest);
    if (reach.size() < 3) return reach;
    while (std::count_if(reach.begin(), reach.end(), [&](std::size_t i) {
             return (leaves_[i].center_G - origin).squaredNorm() <= radius * radius;
           }) < 3)
      radius *= growth;
    while (true) {
      const std::vector<std::size_t> members = inliers(plane, origin, radius);
      if (members.size() >= 3) refit(members, plane);
      if (radius >= farthest) return members.size() < 3 ? members : inliers(plane, origin, radius);
      radius *= growth;
    }
  }

  std::vector<std::size_t> inliers(const Plane& plane, const Vector3d& origin, double radius) const {
    return free_.near(plane, origin, radius, std::cos(max_normal_angle_rad), options_.tolerance_m);
  }

  void refit(const std::vector<std::size_t>& members, Plane& plane) const {
    double total = 0.0;
    Vector3d center = Vector3d::Zero();
    for (const std::size_t i : members) {
      total += weight(i);
      center += weight(i) * leaves_[i].center_G;
    }
    center /= total;
    Matrix3d S = Matrix3d::Zero();
    for (const std::size_t i : members) {
      const Vector3d d = leaves_[i].center_G - center;
      // The leaf's own extent holds the plane's tilt where the leaves stand in one line.
      const Matrix3d across = Matrix3d::Identity() - leaves_[i].normal_G * leaves_[i].normal_G.transpose();
      S += weight(i) * (d * d.transpose() + leaves_[i].size_m * leaves_[i].size_m / 12.0 * across);
    }
    plane = {center, symmetric_eigen_fast(S).vectors.col(0)};
  }

  // A leaf counts by its area once it is known better than the surface is flat.
  double weight(std::size_t i) const {
    const double floor = min_flatness_m * min_flatness_m;
    return leaves_[i].size_m * leaves_[i].size_m / (1.0 / information_[i] + floor);
  }

  PlaneFeature merge(const std::vector<std::size_t>& members, const Plane& plane) const {
    // How far leaves stand off, each by its weight: that of a small one is mostly its own noise.
    double total = 0.0;
    double total2 = 0.0;
    double squares = 0.0;
    double noise2 = 0.0;
    for (const std::size_t i : members) {
      const double w = weight(i);
      total += w;
      total2 += w * w;
      squares += w * std::pow(plane.normal.dot(leaves_[i].center_G - plane.center), 2);
      noise2 += w / information_[i];
    }
    const double as_many = total * total / total2;
    const double uneven2 =
        unevenness2(squares / total * as_many / std::max(1.0, as_many - 3.0), noise2 / total, as_many);
    // Information of each block of the surface, to be brought down to one measurement of that flatness.
    const Vector3d t1 = plane.normal.unitOrthogonal();
    const Vector3d t2 = plane.normal.cross(t1);
    const auto block_of = [&](const PlaneFeature& leaf) {
      const Vector3d d = leaf.center_G - plane.center;
      return std::pair(std::floor(t1.dot(d) / block_m), std::floor(t2.dot(d) / block_m));
    };
    std::map<std::pair<double, double>, double> block_information;
    for (const std::size_t i : members) block_information[block_of(leaves_[i])] += information_[i];

    std::map<std::pair<int, int>, std::vector<Part>> by_patch;
    for (const std::size_t i : members) {
      PlaneFeature& leaf = leaves_[i];
      leaf.merged_share = 1.0 / (1.0 + block_information[block_of(leaf)] * uneven2);
      for (std::size_t k = 0; k < leaf.observations.size(); ++k) {
        const PlaneObservation& o = leaf.observations[k];
        const RayMoments* rays = leaf.rays.empty() ? nullptr : &leaf.rays[k];
        by_patch[{o.stop, o.lidar}].push_back({&o, rays, leaf.merged_share});
      }
    }
    PlaneFeature out;
    out.center_G = plane.center;
    out.normal_G = plane.normal;
    out.merged = true;
    for (const auto& [patch, parts] : by_patch) {
      out.observations.push_back(sum_of(patch, parts));
      if (parts.front().rays != nullptr) out.rays.push_back(rays_of(parts, out.observations.back()));
    }
    for (const std::size_t i : members) {
      for (PlaneObservation& o : leaves_[i].observations) o.weight *= 1.0 - leaves_[i].merged_share;
    }
    return out;
  }

  // Of the surface, m^2: from the mean square that `as_many` leaves stand off it, and that which their noise lets
  // expect.
  [[nodiscard]] double unevenness2(double seen2, double noise2, double as_many) const {
    const double least2 = min_flatness_m * min_flatness_m;
    if (!options_.trust_noise) return seen2 + least2;
    // Chance may hide as much as the mean square itself is unsure of.
    return std::max(0.0, seen2 - noise2) + std::sqrt(2.0 / as_many) * noise2 + least2 / 25.0;
  }

  struct Part {
    const PlaneObservation* o;
    const RayMoments* rays;
    double scale;
  };

  // One weighted cluster of all that a patch saw of the merged plane; the weights are in N, mean and scatter.
  static PlaneObservation sum_of(const std::pair<int, int>& patch, const std::vector<Part>& parts) {
    PlaneObservation sum;
    sum.stop = patch.first;
    sum.lidar = patch.second;
    for (const auto& [o, rays, scale] : parts) {
      const double w = scale * o->weight * o->N;
      sum.N += w;
      sum.mean += w * o->mean;
      sum.offset_variance += scale / o->offset_variance;
    }
    sum.mean /= sum.N;
    for (const auto& [o, rays, scale] : parts) {
      const double w = scale * o->weight;
      const Vector3d d = o->mean - sum.mean;
      sum.scatter += w * (o->scatter + o->N * d * d.transpose());
    }
    sum.offset_variance = 1.0 / sum.offset_variance;
    return sum;
  }

  static RayMoments rays_of(const std::vector<Part>& parts, const PlaneObservation& sum) {
    RayMoments out;
    for (const auto& [o, rays, scale] : parts) {
      const double w = scale * o->weight * o->N;
      out.mean += w * rays->mean;
      out.darkness += w * rays->darkness;
    }
    out.mean /= sum.N;
    out.darkness /= sum.N;
    for (const auto& [o, rays, scale] : parts) {
      const double w = scale * o->weight;
      const Vector3d d = rays->mean - out.mean;
      out.cross += w * (rays->cross + o->N * (o->mean - sum.mean) * d.transpose());
      out.scatter += w * (rays->scatter + o->N * d * d.transpose());
    }
    return out;
  }

  std::vector<PlaneFeature>& leaves_;
  const MergeOptions& options_;
  std::vector<double> information_;
  std::vector<char> taken_;
  FreeLeaves free_;
};

}  // namespace

std::vector<PlaneFeature> merge_coplanar(std::vector<PlaneFeature>& leaves, const MergeOptions& options) {
  return Merger(leaves, options).run();
}

}  // namespace rigcal
