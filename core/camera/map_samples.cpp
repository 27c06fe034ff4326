#include "core/camera/map_samples.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "core/base/parallel.h"
#include "core/voxel/cube_index.h"
#include "core/voxel/world_points.h"

namespace rigcal {
namespace {

// A sample lies on a leaf whose plane it is so near to,
constexpr float max_offset_m = 0.03F;
// and whose middle so many edges of its voxel: leaves know the size of their voxel, not their outline.
constexpr float reach_per_size = 0.75F;
// Of the cubes by which leaves are found.
constexpr float leaf_cube_m = 0.5F;

// Reflectivities of a cube that are kept: bounds the memory by the surface, and is plenty for a median.
constexpr std::uint32_t max_values = 32;

// What one point of a cube said.
struct Value {
  std::uint32_t cube;
  std::uint8_t lidar;
  std::uint8_t reflectivity;
};

// A sample while it grows. Sums are taken from the first point, so that floats do.
struct Growing {
  Eigen::Vector3f first;
  Eigen::Vector3f sum = Eigen::Vector3f::Zero();
  std::uint32_t count = 0;
  std::uint32_t patch = 0;  // who saw it first
};

struct Shard {
  std::vector<Growing> cubes;
  std::vector<Value> values;
};

// The plane leaves, found by place.
class LeafFinder {
 public:
  explicit LeafFinder(const std::vector<PlaneFeature>& leaves) {
    std::vector<std::pair<std::uint32_t, std::uint32_t>> entries;  // cube, plane
    for (const PlaneFeature& leaf : leaves) {
      if (leaf.merged) continue;
      const Plane plane{leaf.center_G.cast<float>(), leaf.normal_G.cast<float>(),
                        reach_per_size * static_cast<float>(leaf.size_m)};
      const auto index = static_cast<std::uint32_t>(planes_.size());
      planes_.push_back(plane);
      for_each_cube(plane, [&](std::uint64_t key) { entries.emplace_back(cubes_.meet(key).number, index); });
    }
    std::sort(entries.begin(), entries.end());
    starts_.assign(cubes_.size() + 1, 0);
    for (const auto& [cube, plane] : entries) {
      ++starts_[cube + 1];
      members_.push_back(plane);
    }
    for (std::size_t i = 1; i < starts_.size(); ++i) starts_[i] += starts_[i - 1];
  }

  // The normal of the nearest leaf; zero where there is none.
  [[nodiscard]] Eigen::Vector3f normal_at(const Eigen::Vector3f& p) const {
    Eigen::Vector3f normal = Eigen::Vector3f::Zero();
    const std::uint32_t cube = cubes_.find(cube_key(p, 1.0 / leaf_cube_m));
    if (cube == KeyNumbers::unknown) return normal;
    float nearest = max_offset_m;
    for (std::uint32_t k = starts_[cube]; k < starts_[cube + 1]; ++k) {
      const Plane& plane = planes_[members_[k]];
      const Eigen::Vector3f d = p - plane.center;
      const float offset = std::abs(plane.normal.dot(d));
      if (offset > nearest || d.squaredNorm() > plane.reach_m * plane.reach_m) continue;
      nearest = offset;
      normal = plane.normal;
    }
    return normal;
  }

 private:
  struct Plane {
    Eigen::Vector3f center;
    Eigen::Vector3f normal;
    float reach_m;
  };

  template <class Visit>
  static void for_each_cube(const Plane& plane, const Visit& visit) {
    const auto steps = static_cast<int>(std::ceil(plane.reach_m / leaf_cube_m)) + 1;
    const Eigen::Vector3f corner =
        ((plane.center / leaf_cube_m).array().floor() + 0.5F).matrix() * leaf_cube_m;  // middle of its own cube
    const float half = 0.5F * leaf_cube_m;
    for (int x = -steps; x <= steps; ++x) {
      for (int y = -steps; y <= steps; ++y) {
        for (int z = -steps; z <= steps; ++z) {
          const Eigen::Vector3f middle =
              corner +
              leaf_cube_m * Eigen::Vector3f(static_cast<float>(x), static_cast<float>(y), static_cast<float>(z));
          const Eigen::Vector3f d = middle - plane.center;
          if (d.norm() > plane.reach_m + std::sqrt(3.0F) * half) continue;
          if (std::abs(plane.normal.dot(d)) > max_offset_m + half * plane.normal.cwiseAbs().sum()) continue;
          visit(cube_key(middle, 1.0 / leaf_cube_m));
        }
      }
    }
  }

  std::vector<Plane> planes_;
  KeyNumbers cubes_;
  std::vector<std::uint32_t> starts_;
  std::vector<std::uint32_t> members_;
};

// The LiDAR with most of the values, and their median.
void set_reflectivity(std::span<const Value> values, MapSample& sample) {
  std::array<std::uint32_t, 256> count{};
  std::uint8_t most = values.front().lidar;
  for (const Value& v : values) {
    if (++count[v.lidar] > count[most]) most = v.lidar;
  }
  std::array<std::uint8_t, max_values> of_most{};
  std::size_t n = 0;
  for (const Value& v : values) {
    if (v.lidar == most) of_most[n++] = v.reflectivity;
  }
  const auto middle = of_most.begin() + static_cast<std::ptrdiff_t>(n / 2);
  std::nth_element(of_most.begin(), middle, of_most.begin() + static_cast<std::ptrdiff_t>(n));
  sample.reflectivity = *middle;
  sample.lidar = most;
}

// The values sorted by their cubes, in their order within each; the starts of the cubes go to `starts`.
std::vector<Value> by_cube(const Shard& shard, std::vector<std::uint32_t>& starts) {
  starts.assign(shard.cubes.size() + 1, 0);
  for (const Value& v : shard.values) ++starts[v.cube + 1];
  for (std::size_t i = 1; i < starts.size(); ++i) starts[i] += starts[i - 1];
  std::vector<std::uint32_t> next(starts.begin(), starts.end() - 1);
  std::vector<Value> sorted(shard.values.size());
  for (const Value& v : shard.values) sorted[next[v.cube]++] = v;
  return sorted;
}

std::vector<MapSample> finished(const Shard& shard, const std::vector<Eigen::Vector3f>& seen_from,
                                const LeafFinder& leaves) {
  std::vector<std::uint32_t> starts;
  const std::vector<Value> values = by_cube(shard, starts);
  std::vector<MapSample> samples(shard.cubes.size());
  for (std::size_t c = 0; c < shard.cubes.size(); ++c) {
    const Growing& cube = shard.cubes[c];
    MapSample& sample = samples[c];
    sample.p_G = cube.first + cube.sum / static_cast<float>(cube.count);
    sample.normal_G = leaves.normal_at(sample.p_G);
    if (sample.normal_G.dot(seen_from[cube.patch] - sample.p_G) < 0.0F) sample.normal_G = -sample.normal_G;
    set_reflectivity(std::span(values).subspan(starts[c], starts[c + 1] - starts[c]), sample);
  }
  return samples;
}

}  // namespace

// Patch by patch, so that the memory grows with the surface and not with the points.
std::vector<MapSample> sample_map(const std::vector<PatchCells>& patches, const RigState& state,
                                  const std::vector<char>& use, const std::vector<PlaneFeature>& leaves,
                                  double size_m) {
  std::vector<Shard> shards(CubeIndex::shards);
  CubeIndex index(size_m);
  std::vector<Eigen::Vector3f> seen_from(patches.size());
  for (std::size_t k = 0; k < patches.size(); ++k) {
    if (!use.empty() && !use[k]) continue;
    const PatchCells& patch = patches[k];
    seen_from[k] = state.T_G_sensor(patch.stop, patch.lidar).t.cast<float>();
    const std::vector<Eigen::Vector3f> world = world_points(patch, state);
    index.add(world, [&](std::size_t s, std::uint32_t cube, std::uint32_t i, bool first) {
      Shard& shard = shards[s];
      if (first) shard.cubes.push_back({world[i], Eigen::Vector3f::Zero(), 0, static_cast<std::uint32_t>(k)});
      Growing& growing = shard.cubes[cube];
      growing.sum += world[i] - growing.first;
      if (growing.count++ >= max_values) return;
      shard.values.push_back({cube, static_cast<std::uint8_t>(patch.lidar), patch.thinned[i].reflectivity});
    });
  }
  const LeafFinder finder(leaves);
  std::vector<std::vector<MapSample>> parts(shards.size());
  parallel_for(shards.size(), 4, [&](std::size_t begin, std::size_t end) {
    for (std::size_t s = begin; s < end; ++s) parts[s] = finished(shards[s], seen_from, finder);
  });
  std::vector<MapSample> samples;
  for (const std::vector<MapSample>& part : parts) samples.insert(samples.end(), part.begin(), part.end());
  return samples;
}

}  // namespace rigcal
