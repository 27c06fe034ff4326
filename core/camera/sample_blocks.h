#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/camera/camera_scene.h"
#include "core/rig/camera_model.h"

namespace rigcal {

/// The map is cut into blocks of so many samples' cubes each way.
constexpr int sample_block_cubes = 40;

/// Where the samples of each block are, as sample_map sorts them, and the ball that holds them: cut wherever the cube
/// of `size_m` changes from one sample to the next.
[[nodiscard]] std::vector<SampleBlock> blocks_of(std::span<const MapSample> samples,
                                                 double size_m = 0.05 * sample_block_cubes);

/// All within an angle of a camera's axis: quicker asked than a lens, and most of a map lies beside or behind.
class ViewCone {
 public:
  /// `half_rad` from the axis, at most pi.
  ViewCone(const SE3& T_C_G, double half_rad);
  /// So wide that nothing in the image lies outside, with the margin of `widest_cos`.
  ViewCone(const SE3& T_C_G, const CameraModel& model);

  [[nodiscard]] bool holds(const Eigen::Vector3f& p_G) const {
    const Eigen::Vector3f d = p_G - apex_;
    const float along = axis_.dot(d);
    const float limit2 = cos_ * cos_ * d.squaredNorm();
    return cos_ >= 0.0F ? along > 0.0F && along * along >= limit2 : along > 0.0F || along * along <= limit2;
  }
  /// Whether the block's ball reaches into the cone.
  [[nodiscard]] bool meets(const SampleBlock& block) const;
  /// From the apex to the middle of the block's ball.
  [[nodiscard]] float distance(const SampleBlock& block) const { return (block.middle - apex_).norm(); }

 private:
  Eigen::Vector3f apex_;
  Eigen::Vector3f axis_;
  float half_rad_;
  float cos_;
};

/// The first index from `begin` on of those that take part where every `stride`-th does.
[[nodiscard]] constexpr std::size_t first_from(std::size_t begin, std::size_t stride) {
  return (begin + stride - 1) / stride * stride;
}

/// Calls `visit(begin, end)` for the runs of samples that may lie in a cone; without blocks for all `count` at once.
template <class Visit>
void for_each_run(std::size_t count, std::span<const SampleBlock> blocks, const ViewCone& cone, const Visit& visit) {
  if (blocks.empty()) visit(std::size_t{0}, count);
  for (const SampleBlock& block : blocks) {
    if (cone.meets(block)) visit(std::size_t{block.begin}, std::size_t{block.end});
  }
}

}  // namespace rigcal
