#pragma once

#include <cstdint>
#include <vector>

#include "core/voxel/cells.h"
#include "core/voxel/noise_model.h"
#include "core/voxel/plane_feature.h"
#include "core/voxel/rig_state.h"

namespace rigcal {

/// A point on an edge where two surfaces meet, in the world. Depth is continuous there, so unlike a silhouette it has
/// no bleeding points, and it stays where it is whoever looks.
struct LidarEdge {
  Vector3d p_G = Vector3d::Zero();
  Vector3d direction_G = Vector3d::UnitX();  ///< Along the edge, unit.
  Vector3d normal_a_G = Vector3d::UnitY();   ///< Of the two faces, unit.
  Vector3d normal_b_G = Vector3d::UnitZ();
  Matrix3d covariance_G = Matrix3d::Zero();  ///< Of p across the edge, m^2; nothing along it.
  double shift_m = 0.0;  ///< Sigma of what the whole line may be off across itself beside that: the beam's width.
  int line = 0;          ///< Samples of one physical edge have the same; they err together.
};

/// Edges of the map that stands: intersections of neighbouring leaves that are not parallel, each piece fitted anew
/// from the points around it (a leaf is too large to be flat to a millimetre), sampled where both faces are really
/// there. `leaves` are features of the plane map (merged ones are left out), `patches` need their thinned points,
/// `noise` an entry a LiDAR, `use` says which patches take part (empty: all). Deterministic whatever the number of
/// threads.
[[nodiscard]] std::vector<LidarEdge> find_lidar_edges(const std::vector<PlaneFeature>& leaves,
                                                      const std::vector<PatchCells>& patches, const RigState& state,
                                                      const std::vector<NoiseModel>& noise,
                                                      const std::vector<char>& use);

}  // namespace rigcal
