#pragma once

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "core/voxel/ray_grid.h"

namespace rigcal {

/// One cell of a RayGrid by its parts, the points of one direction each; most cells are hit in a few only.
struct CellParts {
  std::uint32_t hit = 0;  ///< A bit for each part that has points.
  /// About the cell's middle, m: ahead, left and up. Without meaning where nothing is hit.
  std::array<CellSums, cell_sixteenths> sums;
  /// How many points lie at the borders across the rays, for the density there: within `border_share` of the cell's
  /// depth. Where nothing is hit they may be those of the cell on the other side.
  std::array<double, cell_sixteenths> at_near;
  std::array<double, cell_sixteenths> at_far;
  std::array<double, cell_sixteenths> dark;  ///< Sum of the points' darkness, likewise.

  void clear() {
    hit = 0;
    at_near.fill(0.0);
    at_far.fill(0.0);
    dark.fill(0.0);
  }
  /// That of a part, which counts as hit from now on.
  CellSums& of(std::size_t part) {
    if ((hit >> part & 1U) == 0) {
      hit |= 1U << part;
      sums[part] = CellSums{};
    }
    return sums[part];
  }
};

/// Of a cell's depth: how near to a border points count as at it. It is less than noise is wide, 2 cm, so that what
/// lies there is what noise moves to and fro.
constexpr double border_share = 1.0 / 16.0;

/// Makes flat pieces of surface of cells that come in the order of their keys: cells, with the next behind where a
/// border between both cuts a surface by its noise, divided into quarters and sixteenths where they are not flat.
///
/// The grid must outlive what is made of its cells. It knows places of its own, so that it stays where it is.
class PieceMaker {
 public:
  PieceMaker() = default;
  PieceMaker(const PieceMaker&) = delete;
  PieceMaker& operator=(const PieceMaker&) = delete;

  void begin(const RayGrid& grid);
  /// The cell to fill in next, with no points yet. It counts once `take` has its key, which must be above those before.
  CellParts& next() {
    next_->clear();
    return *next_;
  }
  void take(std::uint64_t key);
  /// Of all that was taken, in the sensor's frame, m; until the next `begin`.
  [[nodiscard]] const std::vector<Cell>& finish();

 private:
  void append_pieces(bool has_behind);

  const RayGrid* grid_ = nullptr;
  std::array<CellParts, 2> parts_;
  CellParts* cell_ = &parts_[0];  // one that another one may still be joined to
  CellParts* next_ = &parts_[1];
  bool has_cell_ = false;
  std::uint64_t key_ = 0;
  std::uint64_t end_ = 0;  // the key behind it: one more where two are one
  std::vector<Cell> pieces_;
};

}  // namespace rigcal
