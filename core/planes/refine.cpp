#include "core/planes/refine.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/median.h"
#include "core/base/parallel.h"
#include "core/base/wide.h"
#include "core/geometry/chi_square.h"
#include "core/planes/merge_planes.h"

namespace rigcal {
namespace {

// Below it passes only shuffle cells at the voxels' borders: another grid moves more (adjust_over_grids).
constexpr double settled_m = 2.5e-4;
constexpr double settled_rad = 4e-5;
// Of a step within a pass that is its last: the next map changes more than is left.
constexpr double last_step_m = 2e-6;
constexpr double last_step_rad = 2e-7;

// Some directions, looked at together.
using Lanes = EightLanes;
constexpr std::size_t lanes = Lanes::count;

// Weighted normals, each coordinate by itself.
struct Facing {
  std::array<std::vector<double>, 3> normal;
  std::vector<double> weight;
};

// Adds to each candidate's sum the weights of all that lies as near to its direction, or to the opposite.
RIGCAL_WIDE void add_near(const Facing& all, const std::array<Lanes, 3>& candidates, double near, Lanes& sums) {
  const double* const x = all.normal[0].data();
  const double* const y = all.normal[1].data();
  const double* const z = all.normal[2].data();
  const double* const weight = all.weight.data();
  Lanes sum = sums;
  for (std::size_t i = 0; i < all.weight.size(); ++i) {
    Lanes dot;
    dot.v = x[i] * candidates[0].v + y[i] * candidates[1].v + z[i] * candidates[2].v;
    for (std::size_t k = 0; k < lanes; ++k) sum.v[k] += std::abs(dot.v[k]) < near ? 0.0 : weight[i];
  }
  sums = sum;
}

// Mean of the normals within ten degrees of the direction that most of them share, among those across `across`.
Vector3d strongest(const std::vector<Vector3d>& normals, const std::vector<double>& weights, const Vector3d& across) {
  const double near = std::cos(to_rad(10.0));
  const auto eligible = [&](const Vector3d& n) { return std::abs(n.dot(across)) < 0.5; };
  Facing all;
  for (std::size_t i = 0; i < normals.size(); ++i) {
    if (!eligible(normals[i])) continue;
    for (std::size_t k = 0; k < 3; ++k) all.normal[k].push_back(normals[i][static_cast<Eigen::Index>(k)]);
    all.weight.push_back(weights[i]);
  }
  const std::size_t step = std::max<std::size_t>(1, normals.size() / 300);
  std::vector<Vector3d> candidates;
  for (std::size_t i = 0; i < normals.size(); i += step) {
    if (eligible(normals[i])) candidates.push_back(normals[i]);
  }
  std::vector<Lanes> sums((candidates.size() + lanes - 1) / lanes);
  parallel_for(sums.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t group = begin; group < end; ++group) {
      std::array<Lanes, 3> some;
      for (std::size_t k = 0; k < lanes && group * lanes + k < candidates.size(); ++k) {
        const Vector3d& candidate = candidates[group * lanes + k];
        for (std::size_t axis = 0; axis < 3; ++axis) some[axis].v[k] = candidate[static_cast<Eigen::Index>(axis)];
      }
      add_near(all, some, near, sums[group]);
    }
  });
  const Vector3d* best = nullptr;
  double best_weight = 0.0;
  for (std::size_t k = 0; k < candidates.size(); ++k) {
    const double weight = sums[k / lanes].v[k % lanes];
    if (weight <= best_weight) continue;
    best_weight = weight;
    best = &candidates[k];
  }
  Vector3d sum = Vector3d::Zero();
  for (std::size_t i = 0; i < normals.size() && best != nullptr; ++i) {
    const double dot = normals[i].dot(*best);
    if (std::abs(dot) < near || !eligible(normals[i])) continue;
    sum += (dot > 0.0 ? weights[i] : -weights[i]) * normals[i];
  }
  return sum;
}

// Adds the planes that coplanar leaves make together.
void merge_leaves(const RefinePass& pass, PlaneMap& map) {
  if (pass.merge_tolerance_m <= 0.0) return;
  MergeOptions merge;
  merge.tolerance_m = pass.merge_tolerance_m;
  merge.trust_noise = pass.trust_noise;
  std::vector<PlaneFeature> merged = merge_coplanar(map.features, merge);
  std::move(merged.begin(), merged.end(), std::back_inserter(map.features));
}

AdjustOptions adjust_options(const RefineInput& input, const RefinePass& pass) {
  AdjustOptions options = input.adjust;
  options.form = pass.form;
  options.max_iterations = pass.iterations;
  options.translation_tolerance_m = last_step_m;
  options.rotation_tolerance_rad = last_step_rad;
  return options;
}

}  // namespace

std::vector<RefinePass> standard_passes(int tight, int settling) {
  const auto settle_from = static_cast<std::size_t>(2 + tight);
  std::vector<RefinePass> passes(settle_from + static_cast<std::size_t>(settling));
  for (std::size_t i = 2; i < passes.size(); ++i) {
    passes[i].map.with_rays = true;
    passes[i].form = HessianForm::exact;
    if (i >= settle_from) passes[i].grids = grids_to_even_out;
  }
  for (std::size_t i = 0; i < 2; ++i) {
    passes[i].map.gate_slack_m = 0.01;
    passes[i].map.offset_floor_m = 0.005;
    passes[i].map.max_chi2 = 3.0;
    passes[i].map.by_cubes = true;
    passes[i].map.min_size_m = 0.25;
    if (i == 0) passes[i].merge_tolerance_m = 0.02;
  }
  return passes;
}

Expected<RefineSummary> refine(const RefineInput& input, const ParameterLayout& layout,
                               const std::vector<RefinePass>& passes, const RunContext& context, RigState& state) {
  RefineSummary summary;
  for (const RefinePass& pass : passes) {
    if (context.cancelled()) return cancelled_error();
    summary.map = build_plane_map(input.patches, state, input.noise, input.T_grid_G, pass.map, input.use);
    merge_leaves(pass, summary.map);
    const RigState before = state;
    const Expected<AdjustSummary> adjusted =
        pass.grids > 1 ? adjust_over_grids(input, layout, pass, pass.grids, summary.map, context, state)
                       : adjust(summary.map.features, layout, adjust_options(input, pass), state);
    if (!adjusted) return adjusted.error();
    summary.iterations += adjusted->iterations;
    summary.cost_before = adjusted->cost_before;
    summary.cost_after = adjusted->cost_after;
    summary.costs.push_back(adjusted->costs);
    summary.last_moves.clear();
    for (std::size_t i = 0; i < state.T_base_sensor.size(); ++i) {
      const SE3 move = before.T_base_sensor[i].inverse() * state.T_base_sensor[i];
      summary.last_moves.push_back({log_so3(move.R).norm(), move.t.norm()});
    }
  }
  summary.converged = std::all_of(summary.last_moves.begin(), summary.last_moves.end(), [](const ExtrinsicMove& move) {
    return move.rotation_rad < settled_rad && move.translation_m < settled_m;
  });
  return summary;
}

Expected<AdjustSummary> adjust_over_grids(const RefineInput& input, const ParameterLayout& layout,
                                          const RefinePass& pass, int grids, const PlaneMap& first,
                                          const RunContext& context, RigState& state) {
  PlaneMapOptions options = pass.map;
  options.with_rays = false;
  std::vector<PlaneMap> others;
  for (int grid = 1; grid < grids; ++grid) {
    if (context.cancelled()) return cancelled_error();
    // At three grids this is a third or two thirds of each smaller voxel too.
    SE3 T_grid_G = input.T_grid_G;
    T_grid_G.t += Vector3d::Constant(options.root_size_m * grid / grids);
    others.push_back(build_plane_map(input.patches, state, input.noise, T_grid_G, options, input.use));
  }
  parallel_for(others.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) merge_leaves(pass, others[i]);
  });
  std::vector<PlaneFeature> features = first.features;
  for (PlaneMap& map : others) std::move(map.features.begin(), map.features.end(), std::back_inserter(features));
  for (PlaneFeature& feature : features) {
    for (PlaneObservation& o : feature.observations) o.weight /= grids;
  }
  return adjust(features, layout, adjust_options(input, pass), state);
}

double unexplained_offset(const PlaneMap& map, const RigState& state, double floor_of_map_m, double least_leaf_m) {
  // Squares over their freedom, and what noise alone gives: medians of both.
  std::vector<double> squares;
  std::vector<double> expected;
  for (const PlaneFeature& feature : map.features) {
    if (feature.merged || feature.size_m < least_leaf_m) continue;
    for_each_offset(feature, state, [&](const PlaneObservation& o, double e, double freedom) {
      if (freedom < 0.1) return;
      squares.push_back(e * e / freedom);
      expected.push_back(o.offset_variance - floor_of_map_m * floor_of_map_m);
    });
  }
  if (squares.size() < 30) return 0.0;
  return std::sqrt(std::max(0.0, median(std::move(squares)) / chi2_50_1 - median(std::move(expected))));
}

SE3 grid_frame(const std::vector<Vector3d>& normals, const std::vector<Vector3d>& centers,
               const std::vector<double>& weights) {
  SE3 T_grid_G;
  if (normals.empty()) return T_grid_G;
  Vector3d z = strongest(normals, weights, Vector3d::Zero());
  if (z.norm() < 1e-9) return T_grid_G;
  z.normalize();
  Vector3d x = strongest(normals, weights, z);
  x -= z.dot(x) * z;
  if (x.norm() < 1e-9) x = z.unitOrthogonal();
  x.normalize();
  Vector3d centroid = Vector3d::Zero();
  double total = 0.0;
  for (std::size_t i = 0; i < centers.size(); ++i) {
    centroid += weights[i] * centers[i];
    total += weights[i];
  }
  T_grid_G.R.row(0) = x;
  T_grid_G.R.row(1) = z.cross(x);
  T_grid_G.R.row(2) = z;
  T_grid_G.t = -(T_grid_G.R * (centroid / total));
  return T_grid_G;
}

}  // namespace rigcal
