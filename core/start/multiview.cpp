#include "core/start/multiview.h"

#include <algorithm>
#include <cmath>

#include "core/base/parallel.h"
#include "core/planes/point_to_plane.h"
#include "core/planes/positive_solver.h"
#include "core/start/surfel_index.h"

namespace rigcal {
namespace {

constexpr double shrink = 0.7;
constexpr int steps_each = 2;           // Steps at each tolerance.
constexpr double surfel_reach_m = 0.6;  // How far apart the middles of two surfels of one surface may be.
constexpr int max_partners = 4;         // Partners of a surfel, each of another patch.

struct Pair {
  std::uint32_t a;
  std::uint32_t b;
};

class Multiview {
 public:
  Multiview(const std::vector<PatchSurfels>& patches, const ParameterLayout& layout, const MultiviewOptions& options)
      : patches_(patches), layout_(layout), options_(options) {
    for (std::size_t k = 0; k < patches.size(); ++k) {
      for (const Surfel& s : patches[k].surfels) {
        placed_.push_back({patches[k].stop, patches[k].lidar, s.mean});
      }
    }
  }

  void associate(const RigState& state, double tolerance) {
    std::vector<PlacedSurfel> world;
    world.reserve(placed_.size());
    for (std::size_t k = 0; k < patches_.size(); ++k) {
      const SE3 T = state.T_G_sensor(patches_[k].stop, patches_[k].lidar);
      for (const Surfel& s : patches_[k].surfels) {
        world.push_back({T * s.mean, T.R * s.normal, static_cast<int>(k)});
      }
    }
    const SurfelIndex index(world, surfel_reach_m);
    const double min_cosine = std::cos(to_rad(std::min(30.0, 8.0 + 30.0 * tolerance)));
    constexpr std::size_t grain = 512;
    std::vector<std::vector<Pair>> parts((world.size() + grain - 1) / grain);
    parallel_for(world.size(), grain, [&](std::size_t begin, std::size_t end) {
      std::vector<int> partners;
      for (std::size_t i = begin; i < end; ++i) {
        index.find_all(world[i].mean, world[i].normal, min_cosine, tolerance, world[i].group, max_partners, partners);
        for (const int p : partners)
          parts[begin / grain].push_back({static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(p)});
      }
    });
    pairs_.clear();
    for (const auto& part : parts) pairs_.insert(pairs_.end(), part.begin(), part.end());
    normals_.clear();
    for (const PlacedSurfel& s : world) normals_.push_back(s.normal);
  }

  void step(RigState& state, double tolerance) {
    const int n = layout_.size();
    place_all(state);
    const NormalEquations zero{0.0, Eigen::VectorXd::Zero(n), Eigen::MatrixXd::Zero(n, n)};
    const std::size_t grain = pairs_at_a_time(pairs_.size(), static_cast<std::size_t>(n));
    NormalEquations sum = parallel_sum(pairs_.size(), grain, zero, [&](std::size_t begin, std::size_t end) {
      NormalEquations part = zero;
      for (std::size_t i = begin; i < end; ++i) add_pair(pairs_[i], state, tolerance, part);
      return part;
    });
    if (pairs_.empty()) return;
    sum.H.triangularView<Eigen::StrictlyUpper>() = sum.H.transpose().triangularView<Eigen::StrictlyUpper>();
    add_priors(layout_, options_.priors, state, sum);
    // Directions that no pair fixes stay where they are: the damping is that of one pair in ten thousand.
    sum.H.diagonal().array() += 1e-4 * sum.H.diagonal().mean() + 1e-9;
    if (const auto dx = solve_positive(sum.H, -sum.g)) state = layout_.moved(state, *dx);
  }

 private:
  // Each is met in several pairs.
  void place_all(const RigState& state) {
    world_.clear();
    world_.reserve(placed_.size());
    for (const PatchSurfels& patch : patches_) {
      const SE3 T = state.T_G_sensor(patch.stop, patch.lidar);
      for (const Surfel& s : patch.surfels) world_.push_back(T * s.mean);
    }
  }

  void add_pair(const Pair& pair, const RigState& state, double tolerance, NormalEquations& sum) const {
    const SensorPoint& a = placed_[pair.a];
    const SensorPoint& b = placed_[pair.b];
    // The normal is the partner's; each pair is met from both sides, so both normals serve.
    const Vector3d& n = normals_[pair.b];
    const double r = n.dot(world_[pair.a] - world_[pair.b]);
    const double scaled = 2.0 * r / tolerance;
    // Residuals in units of 2 cm, the spread of surfels of one surface; Cauchy weight.
    const double w = 2500.0 / (1.0 + scaled * scaled);
    add_point_to_plane(a, b, n, r, w, layout_, state, sum);
  }

  const std::vector<PatchSurfels>& patches_;
  const ParameterLayout& layout_;
  const MultiviewOptions& options_;
  std::vector<SensorPoint> placed_;
  std::vector<Vector3d> world_;  // where `placed_` stand at this step
  std::vector<Vector3d> normals_;
  std::vector<Pair> pairs_;
};

}  // namespace

std::size_t pairs_at_a_time(std::size_t pairs, std::size_t unknowns) {
  constexpr std::size_t usual = 16384;
  constexpr std::size_t least_sums = 4;  // for the threads
  constexpr std::size_t most_bytes = std::size_t{512} << 20U;
  const std::size_t each = sizeof(double) * unknowns * unknowns;
  const std::size_t sums = std::max(least_sums, most_bytes / std::max<std::size_t>(each, 1));
  return std::max(usual, (pairs + sums - 1) / sums);
}

void align_surfels(const std::vector<PatchSurfels>& patches, const ParameterLayout& layout,
                   const MultiviewOptions& options, RigState& state) {
  if (layout.size() == 0) return;
  Multiview multiview(patches, layout, options);
  for (double tolerance = options.from_m;; tolerance *= shrink) {
    const bool last = tolerance <= options.to_m;
    if (last) tolerance = options.to_m;
    multiview.associate(state, tolerance);
    for (int k = 0; k < steps_each; ++k) multiview.step(state, tolerance);
    if (last) break;
  }
}

}  // namespace rigcal
