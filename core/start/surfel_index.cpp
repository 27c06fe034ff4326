#include "core/start/surfel_index.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>

#include "core/base/floor_of.h"

namespace rigcal {
namespace {

struct Voxel {
  std::int64_t x, y, z;
};

Voxel voxel_of(const Vector3d& p, double size) {
  return {floor_of(p.x() / size), floor_of(p.y() / size), floor_of(p.z() / size)};
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
  for (std::size_t i = 0; i < surfels_.size(); ++i) {
    const PlacedSurfel& s = surfels_[i];
    const Entry entry{s.normal.cast<float>(), s.mean.cast<float>(), s.group, static_cast<std::int32_t>(i)};
    for_each_near_voxel(s.mean, voxel_m_, [&](Voxel v) { entries_[fill[bucket(v.x, v.y, v.z)]++] = entry; });
  }
}

// Calls take(entry, squared distance) until it returns false.
template <class Take>
void SurfelIndex::for_each_fit(const Vector3d& p, const Vector3d& normal, double min_cosine,
                               double max_plane_distance_m, const Take& take) const {
  const Voxel v = voxel_of(p, voxel_m_);
  const std::size_t b = bucket(v.x, v.y, v.z);
  const Eigen::Vector3f place = p.cast<float>();
  const Eigen::Vector3f facing = normal.cast<float>();
  const auto cosine = static_cast<float>(min_cosine);
  const auto off = static_cast<float>(max_plane_distance_m);
  const auto reach = static_cast<float>(voxel_m_ * voxel_m_);
  const Entry* const end = entries_.data() + bucket_start_[b + 1];
  for (const Entry* e = entries_.data() + bucket_start_[b]; e != end; ++e) {
    if (e->normal.dot(facing) < cosine) continue;
    const Eigen::Vector3f d = place - e->mean;
    if (std::abs(e->normal.dot(d)) > off) continue;
    const float distance = d.squaredNorm();
    if (distance <= reach && !take(*e, distance)) return;
  }
}

int SurfelIndex::find(const Vector3d& p, const Vector3d& normal, double min_cosine, double max_plane_distance_m,
                      int not_group) const {
  int best = -1;
  float best_distance = std::numeric_limits<float>::max();
  for_each_fit(p, normal, min_cosine, max_plane_distance_m, [&](const Entry& e, float distance) {
    // Two equal hits (a hash collision enters a surfel twice) leave the first.
    if (distance < best_distance && e.group != not_group) {
      best_distance = distance;
      best = e.surfel;
    }
    return true;
  });
  return best;
}

bool SurfelIndex::contains(const Vector3d& p, const Vector3d& normal, double min_cosine,
                           double max_plane_distance_m) const {
  bool found = false;
  for_each_fit(p, normal, min_cosine, max_plane_distance_m, [&](const Entry&, float) {
    found = true;
    return false;
  });
  return found;
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
  struct Hit {
    float distance;
    std::int32_t group;
    std::int32_t surfel;
  };
  // A short list kept sorted; few groups meet in one place.
  std::array<Hit, 16> hits{};
  const auto limit = static_cast<std::size_t>(std::clamp(most, 0, static_cast<int>(hits.size())));
  std::size_t count = 0;
  out.clear();
  if (limit == 0) return;
  for_each_fit(p, normal, min_cosine, max_plane_distance_m, [&](const Entry& e, float distance) {
    if (e.group == not_group || (count == limit && distance >= hits[count - 1].distance)) return true;
    std::size_t at = 0;
    while (at < count && hits[at].group != e.group) ++at;
    if (at < count) {
      if (distance >= hits[at].distance) return true;
    } else if (count < limit) {
      at = count++;
    } else {
      at = count - 1;
    }
    hits[at] = {distance, e.group, e.surfel};
    for (; at > 0 && hits[at].distance < hits[at - 1].distance; --at) std::swap(hits[at], hits[at - 1]);
    return true;
  });
  for (std::size_t i = 0; i < count; ++i) out.push_back(hits[i].surfel);
}

}  // namespace rigcal
