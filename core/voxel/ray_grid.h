#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/geometry/se3.h"
#include "core/voxel/cell_sums.h"

namespace rigcal {

/// Directions of a cell, four by four, quarter by quarter.
constexpr std::size_t cell_sixteenths = 16;

/// Of the points of a block: how they lie before the sensor, and where in their cells.
struct PlacedOnRays {
  EachOfBlock<double> depth, left, up;   ///< m.
  EachOfBlock<std::int32_t> face, deep;  ///< Which of the six, and how many cells deep.
  EachOfBlock<double> across;            ///< How many cells side by side fill 45 degrees at that depth.
  EachOfBlock<std::uint64_t> key;
  EachOfBlock<std::uint32_t> sixteenth;
};

/// Which cell, and which of its directions.
struct PlaceInCell {
  std::uint64_t key = 0;
  std::uint32_t sixteenth = 0;
};
/// Of a point at a border between cells of different directions: where it would be on the other side.
struct OtherSide {
  PlaceInCell place;
  bool is_nearer = false;  ///< The point lies at the far border of that cell, else at its near one.
};

/// Cells that lie along the sensor's rays: six faces of a cube around the sensor, directions in steps that are 14 to
/// 20 cm wide where the point is, depth in steps of 20 cm (CellOptions::size_m). Their keys are in order of direction,
/// and then of depth.
class RayGrid {
 public:
  RayGrid() : RayGrid(1.0, 0.2) {}
  /// No point may be farther than the range, below 10 km; `size_m` is the depth of a cell.
  RayGrid(double max_range_m, double size_m);

  /// For all of the block, however many points it has; all within the greatest range.
  void place(const PointBlock& block, PlacedOnRays& at) const;

  [[nodiscard]] double size_m() const { return size_m_; }
  /// Which of the six ways a cell's points lie ahead: along x, y or z, and against them.
  [[nodiscard]] int face_of(std::uint64_t key) const {
    return static_cast<int>(key >> (2 * across_bits_ + deep_bits_));
  }
  /// How many cells deep it lies.
  [[nodiscard]] std::size_t deep_of(std::uint64_t key) const {
    return static_cast<std::size_t>(key & ((std::uint64_t{1} << deep_bits_) - 1));
  }
  /// Whether the cells one deeper, at the next key, are in the same directions.
  [[nodiscard]] bool goes_on_behind(std::uint64_t key) const {
    const std::size_t deep = deep_of(key);
    return across_[deep + 1] == across_[deep];
  }
  /// Whether those one nearer are.
  [[nodiscard]] bool goes_on_before(std::uint64_t key) const {
    const std::size_t deep = deep_of(key);
    return deep == 0 || across_[deep - 1] == across_[deep];
  }
  /// Whether cells of other directions lie before those of this depth, or behind them.
  [[nodiscard]] bool is_at_change(std::int32_t deep) const {
    return is_at_change_[static_cast<std::size_t>(deep)] != 0;
  }
  /// For a point of the block that lies within `border_m` of a border between depths: the cell on the border's other
  /// side in the point's direction. Nothing where that is the one that is named alike, with the depth before or behind.
  [[nodiscard]] std::optional<OtherSide> other_side(const PlacedOnRays& at, std::size_t number, double border_m) const;
  /// The middle of a cell: how far ahead, left and up, m.
  [[nodiscard]] Vector3d middle_ahead(std::uint64_t key) const;

 private:
  double size_m_ = 0.0;
  std::vector<double> across_;      // by depth
  std::vector<char> is_at_change_;  // likewise: other directions lie before or behind
  unsigned across_bits_ = 0;
  unsigned deep_bits_ = 0;
  std::int32_t key_middle_ = 0;  // of what looks left and up in a key: both ways from the middle
};

/// From ahead, left and up on this face to x, y and z in the sensor's frame, m,
[[nodiscard]] Vector3d in_sensor(const Vector3d& p, int face);
/// and so for sums.
[[nodiscard]] CellSums in_sensor(CellSums sums, int face);

}  // namespace rigcal
