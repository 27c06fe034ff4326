#pragma once

#include <vector>

#include "core/start/shape_match.h"
#include "core/voxel/rig_state.h"

namespace rigcal {

/// The shapes that one LiDAR saw from known places, at all levels, for others to be laid on.
class ShapeMap {
 public:
  /// Patches of `lidar` at stops with `stop_known`, each at its T_G_base (the LiDAR is the base).
  ShapeMap(const std::vector<PatchCells>& patches, int lidar, const std::vector<SE3>& T_G_base,
           const std::vector<char>& stop_known);

  /// Lays another LiDAR's patches on the map: the best of what comes of `candidates` for its T_base_sensor. Score 0
  /// where either has no shapes.
  [[nodiscard]] ShapeMatch place(const std::vector<PatchCells>& patches, int lidar,
                                 const std::vector<SE3>& candidates) const;

 private:
  std::vector<SE3> T_G_base_;
  std::vector<char> stop_known_;
  std::vector<ShapeIndex> maps_;  // one for each level
};

}  // namespace rigcal
