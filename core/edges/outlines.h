#pragma once

#include <vector>

#include "core/edges/depth_steps.h"
#include "core/edges/lidar_edges.h"

namespace rigcal {

/// Full width of a LiDAR's beam, upright (towards the sensor's z) and level.
struct BeamWidth {
  double upright_rad = 0.003;
  double level_rad = 0.003;
};

/// What of `find_outlines` does not depend on where the patches stand, see core/edges/step_lines.h.
struct PatchOutlines;

/// Straight outlines of surfaces in the map: where a LiDAR sees something end before a farther background. Each is
/// found in the patch that shows it, so that noise of the poses does not blur it. A single depth step is less sure than
/// an edge where two planes meet (the beam is wide, and mixed points stand between), but there are many more of them,
/// and a facade of glass has hardly anything else. Lines are numbered from `first_line` on; what several patches show
/// of one outline has one number. The order depends on the patches only, not on the number of threads.
/// `beams`: of each LiDAR of the patches; empty: that of BeamWidth for all.
/// `known`: what `find_patch_outlines` gave for each patch with the same beams; null: it is found here.
[[nodiscard]] std::vector<LidarEdge> find_outlines(const std::vector<PatchCells>& patches, const RigState& state,
                                                   const std::vector<char>& use, int first_line,
                                                   const std::vector<BeamWidth>& beams,
                                                   const std::vector<PatchOutlines>* known = nullptr);

}  // namespace rigcal
