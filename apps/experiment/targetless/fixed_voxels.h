#pragma once

#include <vector>

#include "core/edges/lidar_edges.h"

namespace rigcal::targetless {

struct FixedVoxelOptions {
  double size_m = 1.0;
  std::size_t min_points = 60;
  double threshold_m = 0.04;            ///< A point this near belongs to a plane.
  double min_share = 0.1;               ///< Of the voxel's points, for a plane.
  std::size_t planes = 4;               ///< Of a voxel, at most.
  double min_angle_rad = to_rad(30.0);  ///< Between the planes of an edge.
  double sample_m = 0.025;
  double near_m = 0.08;    ///< Both planes have points so near to a sample.
  double sigma_m = 0.005;  ///< That an edge is said to be off by.
};

struct FixedVoxelEdges {
  std::vector<LidarEdge> edges;
  std::size_t voxels = 0;  ///< With enough points.
  std::size_t planes = 0;
  double planes_s = 0.0;
  double edges_s = 0.0;
};

/// Edges of a map by voxels of one size, as cameras were calibrated before there were adaptive ones: planes in each
/// voxel by RANSAC, and where two of them meet with points of both near by, an edge. Points in the world, metres.
/// Deterministic whatever the number of threads, but for the times.
[[nodiscard]] FixedVoxelEdges find_edges_in_fixed_voxels(const std::vector<Vector3d>& points_G,
                                                         const FixedVoxelOptions& options);

}  // namespace rigcal::targetless
