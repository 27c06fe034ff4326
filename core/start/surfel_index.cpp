#include "core/start/surfel_index.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

namespace rigcal {
namespace {

struct Voxel {
  std::int64_t x, y, z;
};

Voxel voxel_of(const Vector3d& p, double size) {
  return {static_cast<std::int64_t>(std::floor(p.x() / size)), static_cast<std::int64_t>(std::floor(p.y() / size)),
          static_cast<std::int64_t>(std::floor(p.z() / size))};
}

// The eight voxels of edge `size` that hold everything within half an edge of p.
template <class F>
void for_each_near_voxel(const Vector3d& p, double size, const F& f) {
  const Voxel low = voxel_of(p - Vector3d::Constant(0.5 * size), size);
  for (std::int64_t dx = 0; dx < 2; ++dx)
    for (std::int64_t dy = 0; dy < 2; ++dy)
      for (std::int64_t dz = 0; dz < 2; ++dz) f(Voxel{low.x + dx, low.y + dy, low.z + dz});
}

}  // namespace

std::size_t SurfelIndex::bucket(std::int64_t x, std::int64_t y, std::int64_t z) const {
  std::uint64_t h = static_cast<std::uint64_t>(x) * 0x9E3779B97F4A7C15ULL;
  h = (h ^ static_cast<std::uint64_t>(y)) * 0xC2B2AE3D27D4EB4FULL;
  h = (h ^ static_cast<std::uint64_t>(z)) * 0x165667B19E3779F9ULL;
  return static_cast<std::size_t>(h >> 24) & mask_;
}

SurfelIndex::SurfelIndex(std::vector<PlacedSurfel> surfels, double reach_m)
    : surfels_(std::move(surfels)), voxel_m_(2.0 * reach_m) {
  std::size_t size = 1024;
  while (size < 4 * surfels_.size()) size *= 2;
  mask_ = size - 1;
  bucket_start_.assign(size + 1, 0);
  for (const PlacedSurfel& s : surfels_)
    for_each_near_voxel(s.mean, voxel_m_, [&](Voxel v) { ++bucket_start_[bucket(v.x, v.y, v.z) + 1]; });
  for (std::size_t i = 1; i < bucket_start_.size(); ++i) bucket_start_[i] += bucket_start_[i - 1];
  entries_.resize(bucket_start_.back());
  std::vector<std::uint32_t> fill(bucket_start_.begin(), bucket_start_.end() - 1);
  for (std::uint32_t i = 0; i < surfels_.size(); ++i)
    for_each_near_voxel(surfels_[i].mean, voxel_m_, [&](Voxel v) { entries_[fill[bucket(v.x, v.y, v.z)]++] = i; });
}

int SurfelIndex::find(const Vector3d& p, const Vector3d& normal, double min_cosine, double max_plane_distance_m,
                      int not_group) const {
  const Voxel v = voxel_of(p, voxel_m_);
  const std::size_t b = bucket(v.x, v.y, v.z);
  int best = -1;
  double best_distance = 1e300;
  for (std::uint32_t e = bucket_start_[b]; e < bucket_start_[b + 1]; ++e) {
    const PlacedSurfel& s = surfels_[entries_[e]];
    if (s.group == not_group || s.normal.dot(normal) < min_cosine) continue;
    const Vector3d d = p - s.mean;
    if (std::abs(s.normal.dot(d)) > max_plane_distance_m) continue;
    const double distance = d.squaredNorm();
    // Two equal hits (a hash collision enters a surfel twice) leave the first.
    if (distance < best_distance && distance <= voxel_m_ * voxel_m_) {
      best_distance = distance;
      best = static_cast<int>(entries_[e]);
    }
  }
  return best;
}

bool SurfelIndex::contains(const Vector3d& p, const Vector3d& normal, double min_cosine,
                           double max_plane_distance_m) const {
  const Voxel v = voxel_of(p, voxel_m_);
  const std::size_t b = bucket(v.x, v.y, v.z);
  for (std::uint32_t e = bucket_start_[b]; e < bucket_start_[b + 1]; ++e) {
    const PlacedSurfel& s = surfels_[entries_[e]];
    if (s.normal.dot(normal) < min_cosine) continue;
    const Vector3d d = p - s.mean;
    if (std::abs(s.normal.dot(d)) <= max_plane_distance_m && d.squaredNorm() <= voxel_m_ * voxel_m_) return true;
  }
  return false;
}

std::vector<PlacedSurfel> without_repetitions(const std::vector<PlacedSurfel>& surfels, double size_m) {
  std::map<std::array<std::int64_t, 3>, std::vector<Vector3d>> seen;
  std::vector<PlacedSurfel> out;
  const double same = std::cos(to_rad(15.0));
  for (const PlacedSurfel& s : surfels) {
    const Voxel v = voxel_of(s.mean, size_m);
    std::vector<Vector3d>& normals = seen[{v.x, v.y, v.z}];
    if (std::any_of(normals.begin(), normals.end(), [&](const Vector3d& n) { return n.dot(s.normal) > same; }))
      continue;
    normals.push_back(s.normal);
    out.push_back(s);
  }
  return out;
}

void SurfelIndex::find_all(const Vector3d& p, const Vector3d& normal, double min_cosine, double max_plane_distance_m,
                           int not_group, int most, std::vector<int>& out) const {
  const Voxel v = voxel_of(p, voxel_m_);
  const std::size_t b = bucket(v.x, v.y, v.z);
  struct Hit {
    double distance;
    int surfel;
  };
  // A short list kept sorted; few groups meet in one place.
  std::array<Hit, 16> hits{};
  const int limit = std::min(most, static_cast<int>(hits.size()));
  int count = 0;
  out.clear();
  if (limit <= 0) return;
  for (std::uint32_t e = bucket_start_[b]; e < bucket_start_[b + 1]; ++e) {
    const PlacedSurfel& s = surfels_[entries_[e]];
    if (s.group == not_group || s.normal.dot(normal) < min_cosine) continue;
    const Vector3d d = p - s.mean;
    if (std::abs(s.normal.dot(d)) > max_plane_distance_m) continue;
    const double distance = d.squaredNorm();
    if (distance > voxel_m_ * voxel_m_ ||
        (count == limit && distance >= hits[static_cast<std::size_t>(count - 1)].distance))
      continue;
    int at = 0;
    while (at < count && surfels_[static_cast<std::size_t>(hits[static_cast<std::size_t>(at)].surfel)].group != s.group)
      ++at;
    if (at < count) {
      if (distance >= hits[static_cast<std::size_t>(at)].distance) continue;
    } else if (count < limit) {
      at = count++;
    } else {
      at = count - 1;
    }
    hits[static_cast<std::size_t>(at)] = {distance, static_cast<int>(entries_[e])};
    for (; at > 0 && hits[static_cast<std::size_t>(at)].distance < hits[static_cast<std::size_t>(at - 1)].distance;
         --at)
      std::swap(hits[static_cast<std::size_t>(at)], hits[static_cast<std::size_t>(at - 1)]);
  }
  for (int i = 0; i < count; ++i) out.push_back(hits[static_cast<std::size_t>(i)].surfel);
}

}  // namespace rigcal
