#pragma once

#include "core/start/shape_match.h"
#include "core/voxel/cells.h"

namespace rigcal {

/// How well two clouds lie on each other, whatever they show: planes decide where b may stand on a, all that both saw
/// decides which of these places it is.
class CloudOverlap {
 public:
  CloudOverlap(const PatchCells& a, const PatchCells& b, const ShapeLevel& level);

  /// Share of what the cloud with fewer shapes saw that lies on the other's at T_a_b, 0 .. 1.
  [[nodiscard]] double score(const SE3& T_a_b) const;
  /// Shapes of the cloud with fewer.
  [[nodiscard]] std::size_t shapes() const { return moving_.items.size(); }

 private:
  bool turned_ = false;  ///< a moves on b.
  ShapeIndex map_;
  MovingShapes moving_;
};

}  // namespace rigcal
