#include "core/camera/sample_blocks.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/base/parallel.h"
#include "core/voxel/cube_key.h"

namespace rigcal {
namespace {

// The ball around the box of some samples.
SampleBlock block_of(std::span<const MapSample> samples, std::uint32_t begin, std::uint32_t end) {
  Eigen::AlignedBox3f box;
  for (std::uint32_t i = begin; i < end; ++i) box.extend(samples[i].p_G);
  SampleBlock block{box.center(), 0.0F, begin, end};
  for (std::uint32_t i = begin; i < end; ++i)
    block.radius_m = std::max(block.radius_m, (samples[i].p_G - block.middle).norm());
  return block;
}

}  // namespace

std::vector<SampleBlock> blocks_of(std::span<const MapSample> samples, double size_m) {
  std::vector<std::uint32_t> starts;
  std::uint64_t last = 0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const std::uint64_t cube = cube_key(samples[i].p_G, 1.0 / size_m);
    if (starts.empty() || cube != last) starts.push_back(static_cast<std::uint32_t>(i));
    last = cube;
  }
  starts.push_back(static_cast<std::uint32_t>(samples.size()));
  std::vector<SampleBlock> blocks(starts.size() - 1);
  parallel_for(blocks.size(), 256, [&](std::size_t begin, std::size_t end) {
    for (std::size_t b = begin; b < end; ++b) blocks[b] = block_of(samples, starts[b], starts[b + 1]);
  });
  return blocks;
}

ViewCone::ViewCone(const SE3& T_C_G, double half_rad)
    : apex_((T_C_G.R.transpose() * -T_C_G.t).cast<float>()),
      axis_(T_C_G.R.row(2).transpose().cast<float>()),
      half_rad_(static_cast<float>(half_rad)),
      cos_(static_cast<float>(std::cos(half_rad))) {}

ViewCone::ViewCone(const SE3& T_C_G, const CameraModel& model)
    : ViewCone(T_C_G, std::acos(std::max(-1.0, model.widest_cos()))) {}

bool ViewCone::meets(const SampleBlock& block) const {
  constexpr float rounding = 1e-3F;
  const Eigen::Vector3f d = block.middle - apex_;
  const float length = d.norm();
  if (length <= block.radius_m) return true;
  const float off_axis = std::acos(std::clamp(axis_.dot(d) / length, -1.0F, 1.0F));
  return off_axis <= half_rad_ + std::asin(block.radius_m / length) + rounding;
}

}  // namespace rigcal
