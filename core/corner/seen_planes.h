#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/corner/fitted_plane.h"
#include "core/voxel/cells.h"

namespace rigcal {

/// What one LiDAR saw at one moment: its points and the same in cells, in its own frame.
struct PlaneCloud {
  std::vector<Vector3d> points;
  PatchCells cells;
};
/// From points in the LiDAR's frame, m.
[[nodiscard]] PlaneCloud plane_cloud(std::span<const Vector3d> points);

/// A plane found in a cloud, fitted to points weighted by how likely they lie on it.
struct SeenPlane {
  FittedPlane plane;  ///< The normal towards the sensor.
  double area_m2 = 0.0;
  double unevenness_m = 0.0;  ///< By how much parts of it stand off it beyond noise (1 sigma): roads are crowned.
  double points_per_part = 1.0;

  /// Of each point in a cost, 1/m^2: what many points of an uneven place say together is bounded.
  [[nodiscard]] double weight() const;
};

/// The large planes of a cloud, by the number of their points, whatever its noise, density and clutter. Surfels of a
/// size that the cloud supports vote for planes, one after the other; then all points are shared out between the planes
/// and what is none of them by their likelihoods, each plane within the places where it was seen, and the planes
/// fitted anew, until they rest. The same points give the same planes in whichever frame, to about rounding.
[[nodiscard]] std::vector<SeenPlane> find_planes(const PlaneCloud& cloud);

}  // namespace rigcal
