#pragma once

#include <vector>

#include "core/geometry/se3.h"
#include "core/voxel/rig_state.h"

namespace rigcal {

/// Keeps passes from going to and fro. Each pass' gates take cells by where the pass before left the rig; some that one
/// of two states takes and the other does not can move it between both for ever. Half the way, both agree.
class DampedPasses {
 public:
  /// After a pass that moved the rig from `before` to `state`: takes half of it back where it mostly undid what the
  /// pass before it did to the LiDARs.
  void take(const RigState& before, RigState& state);

 private:
  std::vector<Vector6d> last_;  // of each LiDAR: rotation times `lever_m`, translation
};

}  // namespace rigcal
