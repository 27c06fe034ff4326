#include "core/start/surfel_index.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>

#include "core/base/wide.h"
#include "core/start/voxel_hash.h"

namespace rigcal {
namespace {

// The eight voxels of edge `size` that hold everything within half an edge of p.
template <class F>
void for_each_near_voxel(const Vector3d& p, double size, const F& f) {
  const Voxel low = voxel_of(p - Vector3d::Constant(0.5 * size), size);
  for (std::int64_t dx = 0; dx < 2; ++dx)
    for (std::int64_t dy = 0; dy < 2; ++dy)
      for (std::int64_t dz = 0; dz < 2; ++dz) f(Voxel{low.x + dx, low.y + dy, low.z + dz});
}

// Entries that are looked at together.
constexpr std::uint32_t at_a_time = 16;

struct Query {
  std::array<float, 3> facing{};
  std::array<float, 3> place{};
  float cosine = 0.0F;
  float off = 0.0F;
  float reach2 = 0.0F;
};

// Which of the first `count` of sixteen entries fit, and how far off they all are, squared. True when any fits.
RIGCAL_WIDE bool look(const std::array<const float*, 6>& entries, const Query& query, std::int32_t count,
                      float* __restrict distance, std::int32_t* __restrict fits) {
  const auto& [a, b, c, x, y, z] = entries;
  std::int32_t any = 0;
  for (std::int32_t i = 0; i < static_cast<std::int32_t>(at_a_time); ++i) {
    const float dx = query.place[0] - x[i];
    const float dy = query.place[1] - y[i];
    const float dz = query.place[2] - z[i];
    const float cosine = a[i] * query.facing[0] + b[i] * query.facing[1] + c[i] * query.facing[2];
    const float off = a[i] * dx + b[i] * dy + c[i] * dz;
    distance[i] = dx * dx + dy * dy + dz * dz;
    fits[i] = static_cast<std::int32_t>(cosine >= query.cosine) &
              static_cast<std::int32_t>(std::abs(off) <= query.off) &
              static_cast<std::int32_t>(distance[i] <= query.reach2) & static_cast<std::int32_t>(i < count);
    any |= fits[i];
  }
  return any != 0;
}

}  // namespace

SurfelIndex::SurfelIndex(std::vector<PlacedSurfel> surfels, double reach_m)
    : surfels_(std::move(surfels)), voxel_m_(2.0 * reach_m) {
  std::size_t size = 1024;
  while (size < 4 * surfels_.size()) size *= 2;
  mask_ = size - 1;
  bucket_start_.assign(size + 1, 0);
  for (const PlacedSurfel& s : surfels_)
    for_each_near_voxel(s.mean, voxel_m_, [&](Voxel v) { ++bucket_start_[(hash_of(v) & mask_) + 1]; });
  for (std::size_t i = 1; i < bucket_start_.size(); ++i) bucket_start_[i] += bucket_start_[i - 1];
  for (std::vector<float>& coordinate : entries_) coordinate.assign(bucket_start_.back() + at_a_time, 0.0F);
  group_.resize(bucket_start_.back());
  surfel_.resize(bucket_start_.back());
  std::vector<std::uint32_t> fill(bucket_start_.begin(), bucket_start_.end() - 1);
  for (std::size_t i = 0; i < surfels_.size(); ++i) {
    const PlacedSurfel& s = surfels_[i];
    for_each_near_voxel(s.mean, voxel_m_, [&](Voxel v) {
      const std::uint32_t at = fill[hash_of(v) & mask_]++;
      for (Eigen::Index k = 0; k < 3; ++k) {
        entries_[static_cast<std::size_t>(k)][at] = static_cast<float>(s.normal[k]);
        entries_[static_cast<std::size_t>(k) + 3][at] = static_cast<float>(s.mean[k]);
      }
      group_[at] = s.group;
      surfel_[at] = static_cast<std::int32_t>(i);
    });
  }
}

// Calls take(place of the entry, squared distance) until it returns false.
template <class Take>
void SurfelIndex::for_each_fit(const Vector3d& p, const Vector3d& normal, double min_cosine,
                               double max_plane_distance_m, const Take& take) const {
  const Voxel v = voxel_of(p, voxel_m_);
  const std::size_t b = hash_of(v) & mask_;
  Query query;
  for (std::size_t k = 0; k < 3; ++k) {
    query.facing[k] = static_cast<float>(normal[static_cast<Eigen::Index>(k)]);
    query.place[k] = static_cast<float>(p[static_cast<Eigen::Index>(k)]);
  }
  query.cosine = static_cast<float>(min_cosine);
  query.off = static_cast<float>(max_plane_distance_m);
  query.reach2 = static_cast<float>(voxel_m_ * voxel_m_);
  const std::uint32_t end = bucket_start_[b + 1];
  std::array<float, at_a_time> distance;
  std::array<std::int32_t, at_a_time> fits;
  for (std::uint32_t begin = bucket_start_[b]; begin < end; begin += at_a_time) {
    const std::array<const float*, 6> entries{&entries_[0][begin], &entries_[1][begin], &entries_[2][begin],
                                              &entries_[3][begin], &entries_[4][begin], &entries_[5][begin]};
    const auto count = static_cast<std::int32_t>(std::min(end - begin, at_a_time));
    if (!look(entries, query, count, distance.data(), fits.data())) continue;
    for (std::uint32_t i = 0; i < static_cast<std::uint32_t>(count); ++i) {
      if (fits[i] != 0 && !take(begin + i, distance[i])) return;
    }
  }
}

int SurfelIndex::find(const Vector3d& p, const Vector3d& normal, double min_cosine, double max_plane_distance_m,
                      int not_group) const {
  int best = -1;
  float best_distance = std::numeric_limits<float>::max();
  for_each_fit(p, normal, min_cosine, max_plane_distance_m, [&](std::uint32_t at, float distance) {
    // Two equal hits (a hash collision enters a surfel twice) leave the first.
    if (distance < best_distance && group_[at] != not_group) {
      best_distance = distance;
      best = surfel_[at];
    }
    return true;
  });
  return best;
}

bool SurfelIndex::contains(const Vector3d& p, const Vector3d& normal, double min_cosine,
                           double max_plane_distance_m) const {
  bool found = false;
  for_each_fit(p, normal, min_cosine, max_plane_distance_m, [&](std::uint32_t, float) {
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
  for_each_fit(p, normal, min_cosine, max_plane_distance_m, [&](std::uint32_t entry, float distance) {
    const std::int32_t group = group_[entry];
    if (group == not_group || (count == limit && distance >= hits[count - 1].distance)) return true;
    std::size_t at = 0;
    while (at < count && hits[at].group != group) ++at;
    if (at < count) {
      if (distance >= hits[at].distance) return true;
    } else if (count < limit) {
      at = count++;
    } else {
      at = count - 1;
    }
    hits[at] = {distance, group, surfel_[entry]};
    for (; at > 0 && hits[at].distance < hits[at - 1].distance; --at) std::swap(hits[at], hits[at - 1]);
    return true;
  });
  for (std::size_t i = 0; i < count; ++i) out.push_back(hits[i].surfel);
}

}  // namespace rigcal
