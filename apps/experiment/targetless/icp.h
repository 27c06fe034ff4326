#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "core/base/run_context.h"
#include "core/planes/normal_equations.h"
#include "core/records/records.h"

/// The experiments of the targetless paper, and the methods that it is compared with.
namespace rigcal::targetless {

struct IcpOptions {
  double spacing_m = 0.1;  ///< Of the points that are kept of a patch: the mean of each cube of this size.
  double max_range_m = 60.0;
  int neighbours = 16;            ///< That a point's normal is fitted to.
  double max_thickness_m = 0.05;  ///< Of these across the normal: what is thicker is no surface and no target.
  std::size_t queries = 300;      ///< Points of a patch, evenly over it, that look for a partner in each other patch.
  double min_cosine = 0.7;        ///< Between the normals of partners.
  double from_m = 2.0;            ///< How far partners may be apart: at first,
  double shrink = 0.8;            ///< less from each matching to the next,
  double to_m = 0.1;              ///< and at last.
};

/// Registration of all patches of all LiDARs with each other by pairs, as LiDARs were calibrated before there were
/// adaptive voxels: every point of a patch is matched with the nearest in each other patch by that patch's k-d tree
/// (nanoflann), and the distances of partners along the target's normal are minimised over all free poses and
/// extrinsics at once, by Gauss-Newton steps with Cauchy weights at the present spread of the distances.
class PairwiseIcp {
 public:
  /// `patches` in the frames of their sensors, which are the LiDARs' numbers.
  PairwiseIcp(const std::vector<Patch>& patches, const IcpOptions& options);
  ~PairwiseIcp();
  PairwiseIcp(PairwiseIcp&&) noexcept;
  PairwiseIcp& operator=(PairwiseIcp&&) noexcept;

  /// Finds partners at `state` no farther apart than `reach_m`; the patches of one LiDAR only where it is named.
  /// Returns how many.
  std::size_t match(const RigState& state, double reach_m, std::optional<int> only_lidar = std::nullopt);
  /// Moves the free blocks so that the partners of the last matching lie on each other.
  void solve(const ParameterLayout& layout, RigState& state) const;

  [[nodiscard]] const IcpOptions& options() const { return options_; }

 private:
  struct Content;
  IcpOptions options_;
  std::unique_ptr<Content> content_;
};

/// What a run of iterations gave and took.
struct IcpRun {
  int iterations = 0;  ///< Of extrinsics.
  bool settled = false;
  double match_s = 0.0;  ///< All of them together, the poses' own apart, as the next.
  double solve_s = 0.0;
  double pose_s = 0.0;  ///< The poses by the base alone, before.
};

struct IcpRunOptions {
  int base = 0;
  int pose_iterations = 6;        ///< Of the base alone; its reach begins at a sixth of the options'.
  int extrinsic_iterations = 10;  ///< At most, with the poses held; then all moves.
  int iterations = 30;            ///< Of extrinsics in all, at most.
  bool stop_when_settled = true;  ///< When nothing moves by more than 0.1 mm and 0.0005 degrees any more.
  std::function<void(const RigState&)> after_iteration = {};
};

/// The three stages: the base's poses, the extrinsics, all. Stop 0 is held. Ends early when `context` is cancelled.
IcpRun run_icp(PairwiseIcp& icp, const IcpRunOptions& options, const RunContext& context, RigState& state);

}  // namespace rigcal::targetless
