#pragma once

#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/base/run_context.h"
#include "core/planes/adjust.h"
#include "core/voxel/plane_map.h"

namespace rigcal {

/// One round: the map is built at the present state, then the free blocks are moved.
struct RefinePass {
  PlaneMapOptions map;
  /// Leaves this near to one plane hold each other; 0: none does. Nearer ones alone would be those that agree with
  /// where everything stands by now, and hold it there.
  double merge_tolerance_m = 0.012;
  bool trust_noise = false;  ///< See MergeOptions.
  HessianForm form = HessianForm::gauss_newton;
  int iterations = 6;
  int grids = 1;  ///< Whose leaves are adjusted together, see `adjust_over_grids`.
};

/// Another grid gives another result: two more even most of that out, and each takes as long as the first.
inline constexpr int grids_to_even_out = 3;

/// Two passes with loose gates for a start that is right to a few centimetres, by cubes, then `tight` ones by pieces,
/// each with a map built anew; the tight ones' maps have rays. The exact Hessian is theirs alone: farther from the end
/// it is often indefinite, and the Gauss-Newton one leads there from more starts. The last `settling` are over several
/// grids, for what the others do not bring to rest: where planes are few, what a leaf's border cuts moves everything.
[[nodiscard]] std::vector<RefinePass> standard_passes(int tight, int settling = 0);

/// How far one pass moved the extrinsic of a LiDAR.
struct ExtrinsicMove {
  double rotation_rad = 0.0;
  double translation_m = 0.0;
};

struct RefineSummary {
  int iterations = 0;
  double cost_before = 0.0;  ///< Of the last pass' map: sum of squared distances over noise.
  double cost_after = 0.0;
  std::vector<std::vector<double>> costs;  ///< Of each pass: before the first iteration and after each.
  bool converged = false;                  ///< The last pass moved no extrinsic by more than is rest.
  std::vector<ExtrinsicMove> last_moves;   ///< Of each LiDAR in the last pass.
  PlaneMap map;                            ///< Of the last pass.
};

/// What stays the same over all passes.
struct RefineInput {
  const std::vector<PatchCells>& patches;
  const std::vector<NoiseModel>& noise;  ///< One for each LiDAR.
  SE3 T_grid_G;
  std::vector<char> use;  ///< Patches that take part; empty: all.
  AdjustOptions adjust;   ///< Its priors; the rest is the passes'.
};

/// Runs the passes from and into `state`.
[[nodiscard]] Expected<RefineSummary> refine(const RefineInput& input, const ParameterLayout& layout,
                                             const std::vector<RefinePass>& passes, const RunContext& context,
                                             RigState& state);

/// Which points a leaf's border leaves to its neighbour moves its plane by more than noise: another grid gives another
/// result. The leaves of `first`, a map built at `state` or near it, are adjusted together with those of as many grids
/// in all, shifted against each other by equal shares of the largest voxel, each counted by as much less.
[[nodiscard]] Expected<AdjustSummary> adjust_over_grids(const RefineInput& input, const ParameterLayout& layout,
                                                        const RefinePass& pass, int grids, const PlaneMap& first,
                                                        const RunContext& context, RigState& state);

/// What real surfaces are not, m (1 sigma): by how much the LiDARs' clusters stand off their common planes beyond what
/// noise explains; a median, so that false partners do not count. Of unevenness that gates might cut off only a map
/// with loose ones tells. Smaller leaves than `least_leaf_m` lie where surfaces meet and do not count. 0 with fewer
/// than 30 observations.
[[nodiscard]] double unexplained_offset(const PlaneMap& map, const RigState& state, double floor_of_map_m,
                                        double least_leaf_m = 0.0);

/// Frame for the grid made from the planes themselves, so that it does not depend on which LiDAR is the base: z along
/// the strongest normal, x along the strongest across it, origin at the centroid. `normals` and `centers` in G,
/// `weights` > 0.
[[nodiscard]] SE3 grid_frame(const std::vector<Vector3d>& normals, const std::vector<Vector3d>& centers,
                             const std::vector<double>& weights);

}  // namespace rigcal
