#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/voxel/plane_map.h"

namespace rigcal {

/// A cell moved to the world. Without values at first: room for a million of them is not to be cleared in vain.
struct WorldCell {
  std::uint64_t key;  ///< Morton code of its smallest voxel in the grid.
  std::uint32_t patch;
  std::uint32_t cell;  ///< Index in the patch.
  double N;
  Vector3d mean;  ///< World frame G.
  Eigen::Matrix<double, 6, 1> scatter;
  float noise_share;  ///< These three as in Cell.
  float noise_shift_per_m;
  float darkness;
};

/// All that fitting needs to know besides the cells of one voxel.
struct GateContext {
  const std::vector<PatchCells>& patches;
  const RigState& state;
  const std::vector<NoiseModel>& noise;
  const PlaneMapOptions& options;
};

/// Total of cells as one cluster about its own mean.
struct CellTotal {
  double N = 0.0;
  Vector3d mean = Vector3d::Zero();
  Matrix3d scatter = Matrix3d::Zero();
};

[[nodiscard]] CellTotal total_of(std::span<const WorldCell> cells);

enum class PlaneVerdict { plane, split };

/// Fits a plane to the cells of one voxel and gates them by columns: cells of one patch that stand in one tangential
/// bin are judged together, since a grid that slices a wall along its normal leaves cells that are half a wall each.
/// Columns off the plane by more than noise allows, or too thick, are left out, and before them single cells, more
/// loosely; the plane is refitted up to four times.
/// On `plane`, `feature` holds the observations and `kept` counts the cells used.
[[nodiscard]] PlaneVerdict gate_plane(std::span<const WorldCell> cells, const CellTotal& total,
                                      const GateContext& context, PlaneFeature& feature, std::size_t& kept);

}  // namespace rigcal
