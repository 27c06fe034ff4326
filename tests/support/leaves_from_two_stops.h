#pragma once

#include "core/voxel/plane_map.h"

namespace rigcal {

/// A rig with one LiDAR at two stops, all of them in one place.
inline RigState state_of_two_stops() { return {{SE3{}, SE3{}}, {SE3{}}}; }

/// Forty level leaves of this size, seen from two stops: one puts them `off_m` above the plane between, the other as
/// far below. Each cluster's offset has this variance, m^2.
inline void add_leaves(double size_m, double off_m, double offset_variance, PlaneMap& map) {
  for (int i = 0; i < 40; ++i) {
    PlaneFeature& leaf = map.features.emplace_back();
    leaf.size_m = size_m;
    for (int stop = 0; stop < 2; ++stop) {
      PlaneObservation& o = leaf.observations.emplace_back();
      o.stop = stop;
      o.N = 100.0;
      o.mean = {0.1 * i, 0.0, stop == 0 ? off_m : -off_m};
      o.scatter = o.N * size_m * size_m / 12.0 * Vector3d(1.0, 1.0, 0.0).asDiagonal().toDenseMatrix();
      o.offset_variance = offset_variance;
    }
  }
}

}  // namespace rigcal
