#pragma once

#include <cstddef>
#include <vector>

#include "core/voxel/cells.h"
#include "core/voxel/noise_model.h"
#include "core/voxel/plane_feature.h"
#include "core/voxel/rig_state.h"

namespace rigcal {

/// When the points of a voxel are a plane, and which of them belong to it. Defaults hold from rooms to fields.
struct PlaneMapOptions {
  static constexpr double root_size_m = 2.0;  ///< Largest voxels.
  double min_size_m = 0.125;
  double min_points = 30.0;
  std::size_t min_patches = 2;  ///< That see it: one alone says nothing about poses, but what it sees is there.
  /// Middle over smallest eigenvalue; larger values drop the sparse scenes' planes.
  static constexpr double min_flatness = 8.0;
  double max_elongation = 25.0;   ///< Largest over middle eigenvalue: beyond it is a line.
  double max_thickness_m = 0.06;  ///< Root of the smallest eigenvalue.
  double gate_slack_m = 0.0;      ///< Added to every gate while the poses are still rough.
  double offset_floor_m = 0.001;  ///< What a real plane is not, for each cluster: caps its weight.
  double max_chi2 = 1.3;          ///< Above this mean square of distance over noise a voxel is split.
  bool with_rays = false;         ///< See PlaneFeature::rays.
  bool by_cubes = false;          ///< Not by pieces: half the time, and blunter where surfaces meet.
};

/// What became of the cells.
struct PlaneMapCounts {
  std::size_t cells = 0;
  std::size_t cells_used = 0;
  std::size_t cells_gated = 0;     ///< In a plane's voxel, but off the plane (people, foliage, edges).
  std::size_t leaves_dropped = 0;  ///< Voxels of too few patches or points; smallest ones that are no plane.
};

struct PlaneMap {
  std::vector<PlaneFeature> features;
  PlaneMapCounts counts;
};

/// Sorts the cells of all patches into an octree of the world and keeps the leaves that are planes seen by enough
/// patches. `noise` has an entry for each LiDAR. `T_grid_G` turns and shifts the grid; choose it from the data, not
/// from a sensor. Only patches with `use[patch]` take part (empty: all). Same input, same output to the bit.
[[nodiscard]] PlaneMap build_plane_map(const std::vector<PatchCells>& patches, const RigState& state,
                                       const std::vector<NoiseModel>& noise, const SE3& T_grid_G,
                                       const PlaneMapOptions& options, const std::vector<char>& use = {});

}  // namespace rigcal
