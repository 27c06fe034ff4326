#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/voxel/cell_sums.h"
#include "core/voxel/key_numbers.h"

namespace rigcal {

constexpr std::size_t cell_sixteenths = 16;

/// Of the points of a block: how they lie before the sensor, and where in their cells.
struct PlacedOnRays {
  EachOfBlock<double> depth, left, up;              ///< m.
  EachOfBlock<std::int32_t> face, deep;             ///< Which of the six, and how many cells deep.
  EachOfBlock<double> across;                       ///< How many cells side by side fill 45 degrees at that depth.
  EachOfBlock<double> off_ahead, off_left, off_up;  ///< From the cell's middle, m.
  EachOfBlock<std::uint64_t> key;
  EachOfBlock<std::int32_t> sixteenth;
};

/// Points of one direction in one cell.
struct PartSums {
  CellSums sums;  ///< About the cell's middle: ahead, left and up.
  /// How many points lie at the borders across the rays, for the density there: within a sixteenth of the cell's depth.
  double at_near = 0.0;
  double at_far = 0.0;

  PartSums& operator+=(const PartSums& other) {
    sums += other.sums;
    at_near += other.at_near;
    at_far += other.at_far;
    return *this;
  }
};

/// Sums the points of one patch by cells that lie along the sensor's rays, since noise moves a point along its ray:
/// borders that lie across would sort points by their noise (docs/decisions/029).
///
/// Six faces of a cube around the sensor, directions in steps that are 14 to 20 cm wide where the point is, depth in
/// steps of 20 cm (CellOptions::size_m); within a cell four by four directions.
class RayTable {
 public:
  /// Forgets what was added and not finished; the memory stays.
  void begin(const CellOptions& options);
  /// Points in metres, all within the options' range.
  void add(const PointBlock& block);
  /// Flat pieces of surface, by direction and then by depth: cells, with the next behind where a border between both
  /// cuts a surface by its noise, divided into quarters and sixteenths where they are not flat. The table is empty
  /// afterwards.
  void finish(PatchCells& out);

 private:
  struct Keyed {
    std::uint64_t key = 0;
    std::uint32_t number = 0;
  };

  using CellParts = std::array<PartSums, cell_sixteenths>;

  void load(std::uint32_t cell, CellParts& out) const;
  bool load_behind(std::span<const Keyed> next, std::uint64_t key, CellParts& parts, CellParts& behind) const;
  void append_pieces(std::uint64_t key, std::uint64_t end, const CellParts& parts);
  void prefetch(std::uint32_t cell) const;

  CellOptions options_;
  std::vector<double> across_;  // see cells_across
  KeyNumbers numbers_;
  std::vector<std::uint64_t> keys_;                                  // of each cell
  std::vector<std::array<std::uint32_t, cell_sixteenths>> sums_of_;  // likewise; most are hit in a few only
  std::vector<PartSums> sums_;
  std::vector<Cell> pieces_;
  PlacedOnRays placed_{};
};

}  // namespace rigcal
