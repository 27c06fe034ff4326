#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/voxel/plane_map.h"

namespace rigcal {

/// A cell moved to the world.
struct WorldCell {
  std::uint64_t key = 0;  ///< Morton code of its smallest voxel in the grid.
  std::uint32_t patch = 0;
  std::uint32_t cell = 0;  ///< Index in the patch.
  double N = 0.0;
  Vector3d mean = Vector3d::Zero();  ///< World frame G.
  Eigen::Matrix<double, 6, 1> scatter = Eigen::Matrix<double, 6, 1>::Zero();
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

/// Fits a plane to the cells of one voxel (sorted by patch) and gates them by columns: cells of one patch that stand in
/// one tangential bin are judged together, since a grid that slices a wall along its normal leaves cells that are half
/// a wall each. Columns off the plane by more than noise allows, or too thick, are left out; the plane is refitted up
/// to four times. On `plane`, `feature` holds the observations and `kept` counts the cells used.
[[nodiscard]] PlaneVerdict gate_plane(std::span<const WorldCell> cells, const CellTotal& total,
                                      const GateContext& context, PlaneFeature& feature, std::size_t& kept);

}  // namespace rigcal
