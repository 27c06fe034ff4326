#include "core/camera/map_samples.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "core/base/parallel.h"
#include "core/camera/sample_blocks.h"
#include "core/voxel/cube_key.h"
#include "core/voxel/key_numbers.h"
#include "core/voxel/world_points.h"

namespace rigcal {
namespace {

// A sample lies on a leaf whose plane it is so near to,
constexpr float max_offset_m = 0.03F;
// and whose middle so many edges of its voxel: leaves know the size of their voxel, not their outline.
constexpr float reach_per_size = 0.75F;
// Of the cubes by which leaves are found.
constexpr float leaf_cube_m = 0.5F;

// Points are sorted into blocks of so many cubes each way, and each block is done by itself: it fits into a cache.
constexpr int block_cubes = sample_block_cubes;

// Of the edge of a cube, in which places are told: a block's fit into 16 bits, finer than any LiDAR measures.
constexpr int cube_parts = 65535 / block_cubes;
constexpr double block_parts = cube_parts * block_cubes;

// A point in its block.
struct Record {
  std::array<std::uint16_t, 3> place;
  std::uint8_t reflectivity;
};

// The points of a patch, block by block.
struct PatchBlocks {
  std::vector<std::uint64_t> keys;  // of the blocks, in the order in which they were met
  std::vector<std::uint32_t> starts;
  std::vector<Record> records;
};

// The part of a patch that lies in a block.
struct Run {
  std::uint32_t patch = 0;
  std::uint32_t block = 0;  // of the patch
};

// What one point of a cube said.
struct Value {
  std::uint8_t lidar;
  std::uint8_t reflectivity;
};

// A sample while it grows; the sum is of places.
struct Growing {
  std::array<std::uint64_t, 3> sum{};
  std::uint32_t count = 0;
  std::uint32_t patch = 0;  // who saw it first
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

// The LiDAR with most of the values, and their median. Sorts them.
void set_reflectivity(std::span<Value> values, MapSample& sample) {
  std::array<std::uint32_t, 256> count{};
  std::uint8_t most = values.front().lidar;
  for (const Value& v : values) {
    if (++count[v.lidar] > count[most]) most = v.lidar;
  }
  const auto of_most = std::partition(values.begin(), values.end(), [&](const Value& v) { return v.lidar == most; });
  const auto middle = values.begin() + (of_most - values.begin()) / 2;
  std::nth_element(values.begin(), middle, of_most,
                   [](const Value& a, const Value& b) { return a.reflectivity < b.reflectivity; });
  sample.reflectivity = middle->reflectivity;
  sample.lidar = most;
}

class MapSampler {
 public:
  // Of each patch's points every `every`-th takes part.
  MapSampler(const std::vector<PatchCells>& patches, const RigState& state, const std::vector<char>& use, double size_m,
             std::size_t every)
      : patches_(patches), block_m_(block_cubes * size_m), of_patch_(patches.size()), seen_from_(patches.size()) {
    parallel_for(patches.size(), 1, [&](std::size_t begin, std::size_t end) {
      for (std::size_t k = begin; k < end; ++k) {
        if (!use.empty() && !use[k]) continue;
        seen_from_[k] = state.T_G_sensor(patches[k].stop, patches[k].lidar).t.cast<float>();
        std::vector<Eigen::Vector3f> world;
        append_world_points(patches[k], state, every, world);
        of_patch_[k] = sorted(patches[k], world, every);
      }
    });
    KeyNumbers numbers;
    for (std::size_t k = 0; k < patches.size(); ++k) {
      for (std::size_t b = 0; b < of_patch_[k].keys.size(); ++b) {
        const KeyNumbers::Met met = numbers.meet(of_patch_[k].keys[b]);
        if (met.first) of_block_.emplace_back();
        of_block_[met.number].push_back({static_cast<std::uint32_t>(k), static_cast<std::uint32_t>(b)});
      }
    }
  }

  [[nodiscard]] std::size_t blocks() const { return of_block_.size(); }

  // The samples of a block, in the order in which its cubes were first met. `cube_at` has a place for each cube, all
  // unknown, and is left so.
  [[nodiscard]] std::vector<MapSample> samples_of(std::size_t block, const LeafFinder& leaves,
                                                  std::vector<std::uint32_t>& cube_at) const {
    std::vector<Growing> cubes;
    std::vector<std::uint32_t> cube_of;  // of each record
    for_each_record(block, [&](std::uint32_t patch, const Record& record) {
      std::uint32_t& cube = cube_at[place_of(record)];
      if (cube == KeyNumbers::unknown) {
        cube = static_cast<std::uint32_t>(cubes.size());
        cubes.push_back({{}, 0, patch});
      }
      Growing& growing = cubes[cube];
      for (std::size_t axis = 0; axis < 3; ++axis) growing.sum[axis] += record.place[axis];
      ++growing.count;
      cube_of.push_back(cube);
    });
    for_each_record(block, [&](std::uint32_t, const Record& r) { cube_at[place_of(r)] = KeyNumbers::unknown; });
    std::vector<std::uint32_t> starts(cubes.size() + 1, 0);
    for (std::size_t c = 0; c < cubes.size(); ++c) starts[c + 1] = starts[c] + cubes[c].count;
    std::vector<Value> values = by_cube(block, cube_of, {starts.begin(), starts.end() - 1});
    const Vector3d corner = corner_of(block);
    std::vector<MapSample> samples(cubes.size());
    for (std::size_t c = 0; c < cubes.size(); ++c) {
      MapSample& sample = samples[c];
      for (int axis = 0; axis < 3; ++axis) {
        const double mean = static_cast<double>(cubes[c].sum[static_cast<std::size_t>(axis)]) / cubes[c].count + 0.5;
        sample.p_G[axis] = static_cast<float>(corner[axis] + block_m_ / block_parts * mean);
      }
      sample.normal_G = leaves.normal_at(sample.p_G);
      if (sample.normal_G.dot(seen_from_[cubes[c].patch] - sample.p_G) < 0.0F) sample.normal_G = -sample.normal_G;
      set_reflectivity(std::span(values).subspan(starts[c], cubes[c].count), sample);
    }
    return samples;
  }

 private:
  static std::size_t place_of(const Record& record) {
    const auto cube = [&](std::size_t axis) { return static_cast<std::size_t>(record.place[axis] / cube_parts); };
    return (cube(0) * block_cubes + cube(1)) * block_cubes + cube(2);
  }

  [[nodiscard]] PatchBlocks sorted(const PatchCells& patch, const std::vector<Eigen::Vector3f>& world,
                                   std::size_t every) const {
    const double per_m = 1.0 / block_m_;
    PatchBlocks out;
    KeyNumbers numbers;
    std::vector<std::uint32_t> block_of(world.size());
    for (std::size_t i = 0; i < world.size(); ++i) {
      const std::uint64_t key = cube_key(world[i], per_m);
      const KeyNumbers::Met met = numbers.meet(key);
      if (met.first) out.keys.push_back(key);
      block_of[i] = met.number;
    }
    out.starts.assign(out.keys.size() + 1, 0);
    for (const std::uint32_t block : block_of) ++out.starts[block + 1];
    for (std::size_t b = 1; b < out.starts.size(); ++b) out.starts[b] += out.starts[b - 1];
    std::vector<std::uint32_t> next(out.starts.begin(), out.starts.end() - 1);
    out.records.resize(world.size());
    for (std::size_t i = 0; i < world.size(); ++i) {
      Record& record = out.records[next[block_of[i]]++];
      for (int axis = 0; axis < 3; ++axis) {
        const double at = world[i][axis] * per_m;
        record.place[static_cast<std::size_t>(axis)] =
            static_cast<std::uint16_t>(std::min(block_parts - 1.0, block_parts * (at - std::floor(at))));
      }
      record.reflectivity = patch.thinned[i * every].reflectivity;
    }
    return out;
  }

  // In the order of the patches.
  template <class Visit>
  void for_each_record(std::size_t block, const Visit& visit) const {
    for (const Run& run : of_block_[block]) {
      const PatchBlocks& patch = of_patch_[run.patch];
      for (std::uint32_t i = patch.starts[run.block]; i < patch.starts[run.block + 1]; ++i)
        visit(run.patch, patch.records[i]);
    }
  }

  // The values of a block's records sorted by their cubes, of which the first goes to `next`.
  [[nodiscard]] std::vector<Value> by_cube(std::size_t block, const std::vector<std::uint32_t>& cube_of,
                                           std::vector<std::uint32_t> next) const {
    std::vector<Value> values(cube_of.size());
    std::size_t i = 0;
    for_each_record(block, [&](std::uint32_t patch, const Record& record) {
      values[next[cube_of[i++]]++] = {static_cast<std::uint8_t>(patches_[patch].lidar), record.reflectivity};
    });
    return values;
  }

  [[nodiscard]] Vector3d corner_of(std::size_t block) const {
    const Run& run = of_block_[block].front();
    return block_m_ * cube_corner(of_patch_[run.patch].keys[run.block]);
  }

  const std::vector<PatchCells>& patches_;
  double block_m_;
  std::vector<PatchBlocks> of_patch_;
  std::vector<Eigen::Vector3f> seen_from_;
  std::vector<std::vector<Run>> of_block_;
};

}  // namespace

std::vector<MapSample> sample_map(const std::vector<PatchCells>& patches, const RigState& state,
                                  const std::vector<char>& use, const std::vector<PlaneFeature>& leaves, double size_m,
                                  std::size_t most_points) {
  std::size_t points = 0;
  for (std::size_t k = 0; k < patches.size(); ++k) {
    if (use.empty() || use[k] != 0) points += patches[k].thinned.size();
  }
  const std::size_t every = std::max<std::size_t>(1, (points + most_points - 1) / most_points);
  const MapSampler sampler(patches, state, use, size_m, every);
  const LeafFinder finder(leaves);
  std::vector<std::vector<MapSample>> of_block(sampler.blocks());
  parallel_for(of_block.size(), 16, [&](std::size_t begin, std::size_t end) {
    std::vector<std::uint32_t> cube_at(block_cubes * block_cubes * block_cubes, KeyNumbers::unknown);
    for (std::size_t b = begin; b < end; ++b) of_block[b] = sampler.samples_of(b, finder, cube_at);
  });
  std::size_t count = 0;
  for (const std::vector<MapSample>& part : of_block) count += part.size();
  std::vector<MapSample> samples;
  samples.reserve(count);
  for (std::vector<MapSample>& part : of_block) {
    samples.insert(samples.end(), part.begin(), part.end());
    part = {};
  }
  return samples;
}

}  // namespace rigcal
