#include "core/planes/merge_planes.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "core/geometry/symmetric_eigen.h"

namespace rigcal {
namespace {

struct Plane {
  Vector3d center;
  Vector3d normal;
};

double information(const PlaneFeature& leaf) {
  double sum = 0.0;
  for (const PlaneObservation& o : leaf.observations) sum += 1.0 / o.offset_variance;
  return sum;
}

class Merger {
 public:
  Merger(std::vector<PlaneFeature>& leaves, const MergeOptions& options)
      : leaves_(leaves), options_(options), taken_(leaves.size(), 0) {
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
      merged.push_back(merge(members, plane));
    }
    return merged;
  }

 private:
  // Farther and farther out, so that the tilt of the first small piece does not decide.
  std::vector<std::size_t> grow(std::size_t seed, Plane& plane) const {
    const Vector3d origin = leaves_[seed].center_G;
    std::vector<std::size_t> members;
    for (double radius = 2.0 * leaves_[seed].size_m;; radius *= 1.6) {
      const bool last = radius >= options_.max_extent_m;
      members = inliers(plane, origin, radius);
      if (members.size() < 3 && last) return members;
      if (members.size() >= 3) refit(members, plane);
      if (last) return inliers(plane, origin, radius);
    }
  }

  std::vector<std::size_t> inliers(const Plane& plane, const Vector3d& origin, double radius) const {
    const double min_cosine = std::cos(options_.max_normal_angle_rad);
    std::vector<std::size_t> out;
    for (std::size_t i = 0; i < leaves_.size(); ++i) {
      if (taken_[i]) continue;
      const PlaneFeature& leaf = leaves_[i];
      if (std::abs(leaf.normal_G.dot(plane.normal)) < min_cosine) continue;
      if (std::abs(plane.normal.dot(leaf.center_G - plane.center)) > options_.tolerance_m) continue;
      if ((leaf.center_G - origin).squaredNorm() > radius * radius) continue;
      out.push_back(i);
    }
    return out;
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
    const double floor = options_.min_flatness_m * options_.min_flatness_m;
    return leaves_[i].size_m * leaves_[i].size_m / (1.0 / information_[i] + floor);
  }

  PlaneFeature merge(const std::vector<std::size_t>& members, const Plane& plane) const {
    double squares = 0.0;
    for (const std::size_t i : members) squares += std::pow(plane.normal.dot(leaves_[i].center_G - plane.center), 2);
    const double flatness2 = squares / static_cast<double>(members.size() - 3 > 0 ? members.size() - 3 : 1) +
                             options_.min_flatness_m * options_.min_flatness_m;
    // Information of each block of the surface, to be brought down to one measurement of that flatness.
    const Vector3d t1 = plane.normal.unitOrthogonal();
    const Vector3d t2 = plane.normal.cross(t1);
    const auto block_of = [&](const PlaneFeature& leaf) {
      const Vector3d d = leaf.center_G - plane.center;
      return std::pair(std::floor(t1.dot(d) / options_.block_m), std::floor(t2.dot(d) / options_.block_m));
    };
    std::map<std::pair<double, double>, double> block_information;
    for (const std::size_t i : members) block_information[block_of(leaves_[i])] += information_[i];

    std::map<std::pair<int, int>, std::vector<Part>> by_patch;
    for (const std::size_t i : members) {
      PlaneFeature& leaf = leaves_[i];
      leaf.counted_again = 1.0 / (1.0 + block_information[block_of(leaf)] * flatness2);
      for (std::size_t k = 0; k < leaf.observations.size(); ++k) {
        const PlaneObservation& o = leaf.observations[k];
        const RayMoments* rays = leaf.rays.empty() ? nullptr : &leaf.rays[k];
        by_patch[{o.stop, o.lidar}].push_back({&o, rays, leaf.counted_again});
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
    return out;
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
    for (const auto& [o, rays, scale] : parts) out.mean += scale * o->weight * o->N * rays->mean;
    out.mean /= sum.N;
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
};

}  // namespace

std::vector<PlaneFeature> merge_coplanar(std::vector<PlaneFeature>& leaves, const MergeOptions& options) {
  return Merger(leaves, options).run();
}

}  // namespace rigcal
