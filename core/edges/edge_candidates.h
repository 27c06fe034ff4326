#pragma once

#include <vector>

#include "core/edges/lidar_edges.h"

namespace rigcal {

inline constexpr double least_edge_angle_rad = to_rad(60.0);  ///< Between the faces.
inline constexpr double edge_piece_m = 0.5;                   ///< Length over which the faces are fitted anew.

/// n.p = d in the world, n unit.
struct WorldPlane {
  Vector3d n = Vector3d::UnitZ();
  double d = 0.0;
  [[nodiscard]] double distance(const Vector3d& p) const { return n.dot(p) - d; }
};

/// A stretch of a line along which two planes may meet.
struct EdgePiece {
  Vector3d middle = Vector3d::Zero();
  Vector3d direction = Vector3d::UnitX();
  WorldPlane a;
  WorldPlane b;
  std::vector<WorldPlane> others;  ///< Leaves near by that are neither: what lies on them belongs to no face.
};

/// Where two planes meet: the point of the line nearest to `near`, and its unit direction. The planes must not be
/// parallel.
struct Line3 {
  Vector3d p;
  Vector3d direction;
};
[[nodiscard]] Line3 intersect(const WorldPlane& a, const WorldPlane& b, const Vector3d& near);

/// Pieces of `edge_piece_m` along the intersections of leaves that lie next to each other. Pieces that several pairs of
/// leaves give are kept once. The order depends on the leaves only.
[[nodiscard]] std::vector<EdgePiece> edge_candidates(const std::vector<PlaneFeature>& features);

}  // namespace rigcal
