#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/geometry/se3.h"
#include "core/voxel/plane_gate.h"
#include "core/voxel/upper_triangle.h"

namespace rigcal {

/// What is summed up of a cell: world frame G, m.
struct GateCell {
  double N;
  Vector3d mean;  ///< Where it is without its noise's shift.
  UpperTriangle scatter;
  float noise_share;  ///< These three as in Cell.
  float noise_shift_per_m;
  float darkness;
  float put_back_m;  ///< How much less far along the normal the mean is now.
  bool kept;
};

/// Cells of one patch in one tangential bin, judged together.
struct GateColumn {
  std::uint32_t first = 0;  ///< Of its cells.
  std::uint32_t count = 0;
  double N = 0.0;
  Vector3d mean = Vector3d::Zero();               ///< World frame G, m.
  UpperTriangle scatter = UpperTriangle::Zero();  ///< Of its points about their mean, m^2.
  double variance = 0.0;                          ///< Of one point along the normal, by the noise model, m^2.
  bool kept = true;
};

/// The columns of one patch, which stand together.
struct PatchColumns {
  std::uint32_t number = 0;  ///< Of the patch among all.
  std::uint32_t first = 0;   ///< Of its columns.
  std::uint32_t end = 0;
  SE3 T_G_sensor;
};

/// The cells of one voxel by patch and tangential bin. Used again for the next voxel, it keeps its memory.
class GateColumns {
 public:
  /// Sorts `cells` into bins of 25 cm across the unit vector `normal_G`, counted from `origin_G`, undoes the shifts of
  /// their means by noise, and sums up their columns.
  void make(std::span<const WorldCell> cells, const GateContext& context, const Vector3d& origin_G,
            const Vector3d& normal_G);
  /// Sums up a column anew, of the cells that are kept; where none is, the mean stays.
  void sum_up(GateColumn& column);

  [[nodiscard]] std::vector<GateColumn>& all() { return columns_; }
  [[nodiscard]] const std::vector<PatchColumns>& patches() const { return patches_; }
  [[nodiscard]] std::span<GateColumn> of(const PatchColumns& patch) {
    return std::span(columns_).subspan(patch.first, patch.end - patch.first);
  }
  [[nodiscard]] std::span<GateCell> cells_of(const GateColumn& column) {
    return std::span(cells_).subspan(column.first, column.count);
  }

  /// Calls `f` for each cell of a column that is kept,
  template <class F>
  void for_each_kept(const GateColumn& column, const F& f) {
    for (GateCell& cell : cells_of(column)) {
      if (cell.kept) f(cell);
    }
  }
  /// and for each of a patch whose column is kept, too.
  template <class F>
  void for_each_kept(const PatchColumns& patch, const F& f) {
    for (const GateColumn& column : of(patch)) {
      if (column.kept) for_each_kept(column, f);
    }
  }

 private:
  void sort(std::span<const WorldCell> cells, const GateContext& context, const Vector3d& origin_G,
            const Vector3d& normal_G);

  std::vector<std::uint32_t> next_;     ///< Of each patch of all, where its next cell goes; 0 while no cell is there.
  std::vector<std::uint32_t> present_;  ///< Patches that have cells here.
  std::vector<std::uint64_t> order_;    ///< Bin and cell, patch by patch, sorted within each.
  std::vector<GateCell> cells_;         ///< In that order.
  std::vector<GateColumn> columns_;
  std::vector<PatchColumns> patches_;
};

}  // namespace rigcal
