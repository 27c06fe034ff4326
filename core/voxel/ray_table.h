#pragma once

#include <cstdint>
#include <vector>

#include "core/voxel/cells.h"
#include "core/voxel/ray_pieces.h"

namespace rigcal {

/// Sums the points of one patch by cells that lie along the sensor's rays, since noise moves a point along its ray:
/// borders that lie across would sort points by their noise (docs/decisions/029).
///
/// A direction of a cell has two or three points as a rule: points are put in the order of their cells and then summed,
/// each cell in the nearest cache, rather than each added to sums that lie all over the memory. What would be too many
/// to wait is summed on the way, and kept as sums.
class RayTable {
 public:
  /// Forgets what was added and not finished; the memory stays.
  void begin(const CellOptions& options);
  /// Points in metres, all within the options' range.
  void add(const PointBlock& block);
  /// Flat pieces of surface, by direction and then by depth. The table is empty afterwards.
  void finish(PatchCells& out);

 private:
  // As it lies before the sensor, m.
  struct WaitingPoint {
    float depth = 0.0F;
    float left = 0.0F;
    float up = 0.0F;
    std::uint8_t sixteenth = 0;
    std::uint8_t reflectivity = 0;
    bool counts_at_border = true;
  };
  static_assert(sizeof(WaitingPoint) == 16);

  // What is summed up, in the order of its cells: a point, or one of another cell that counts at a border with it.
  enum class Part : std::uint8_t { inside, before_near, behind_far };
  struct Keyed {
    std::uint64_t key = 0;
    std::uint32_t number = 0;  // of the waiting point
    Part part = Part::inside;
    std::uint8_t sixteenth = 0;  // of one of another cell
  };

  // Of one direction of one cell.
  struct KeptSums {
    std::uint64_t key = 0;
    std::uint32_t sixteenth = 0;
    double at_near = 0.0;
    double at_far = 0.0;
    double dark = 0.0;
    CellSums sums;
  };

  template <class Next, class Take>
  void for_each_cell(const Next& next, const Take& take);
  void keep_sums();
  void let_lone_ones_be();

  CellOptions options_;
  RayGrid grid_;
  PlacedOnRays placed_{};
  std::vector<WaitingPoint> waiting_;
  std::vector<Keyed> order_;    // of those
  std::vector<KeptSums> kept_;  // by key
  bool has_other_sides_ = false;
  PieceMaker pieces_;
};

}  // namespace rigcal
