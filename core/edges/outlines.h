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

struct OutlineOptions {
  DepthStepOptions steps;
  double min_angle_rad = to_rad(1.0);  ///< Shorter ones are chance; seen from the sensor.
  double min_length_m = 1.0;           ///< And shorter ones are leaves.
  int min_steps = 15;                  ///< So many rays end there.
  double min_filled = 0.5;             ///< Share of its length at which they do.
  double max_gap_spacings = 10.0;
  double across_spacings = 0.9;   ///< Steps so near to a line belong to it.
  double max_rms = 0.55;          ///< Of the steps' distances across, in spacings.
  double max_depth_rms_m = 0.13;  ///< And in depth: leaves scatter more.
  double min_rise_m = 0.25;       ///< Median: a floor seen flat has rows of small steps.
  double sample_m = 0.05;         ///< Samples of a line are so far apart,
  double sample_rad = 0.008;      ///< and at least so far as seen from the sensor.
  /// A surface is met while a part of the beam's width still hits it: outlines lie so far outside, in halves of it.
  double beam_share = 1.0;
  double beam_share_sigma = 0.7;
  std::vector<BeamWidth> beams;  ///< Of each LiDAR of the patches; empty: that of BeamWidth for all.
};

/// What of `find_outlines` does not depend on where the patches stand, see core/edges/step_lines.h.
struct PatchOutlines;

/// Straight outlines of surfaces in the map: where a LiDAR sees something end before a farther background. Each is
/// found in the patch that shows it, so that noise of the poses does not blur it. A single depth step is less sure than
/// an edge where two planes meet (the beam is wide, and mixed points stand between), but there are many more of them,
/// and a facade of glass has hardly anything else. Lines are numbered from `first_line` on; what several patches show
/// of one outline has one number. The order depends on the patches only, not on the number of threads.
/// `known`: what `find_patch_outlines` gave for each patch with the same options; null: it is found here.
[[nodiscard]] std::vector<LidarEdge> find_outlines(const std::vector<PatchCells>& patches, const RigState& state,
                                                   const std::vector<char>& use, int first_line,
                                                   const OutlineOptions& options,
                                                   const std::vector<PatchOutlines>* known = nullptr);

}  // namespace rigcal
