#pragma once

#include <vector>

#include "core/base/random.h"
#include "core/voxel/plane_feature.h"
#include "core/voxel/rig_state.h"

namespace rigcal {

inline SE3 random_pose(Random& random, double rotation_rad, double translation_m) {
  Vector6d xi;
  for (int i = 0; i < 6; ++i) xi[i] = random.normal() * (i < 3 ? rotation_rad : translation_m);
  return SE3::exp(xi);
}

/// The same poses, all but the first stop and the base LiDAR disturbed.
inline RigState disturbed(const RigState& state, Random& random, double rotation_rad, double translation_m) {
  RigState out = state;
  for (std::size_t j = 1; j < out.T_G_base.size(); ++j)
    out.T_G_base[j] = out.T_G_base[j] * random_pose(random, rotation_rad, translation_m);
  for (std::size_t i = 1; i < out.T_base_sensor.size(); ++i)
    out.T_base_sensor[i] = out.T_base_sensor[i] * random_pose(random, rotation_rad, translation_m);
  return out;
}

/// Random planes around the origin, each seen by every LiDAR at every stop with noise of `sigma` along the normal;
/// points are summed as the voxel map would. Weights are 1/sigma^2 (or 1 where sigma is 0).
inline std::vector<PlaneFeature> make_plane_features(const RigState& state, int planes, int points, double sigma,
                                                     Random& random) {
  std::vector<PlaneFeature> features;
  for (int l = 0; l < planes; ++l) {
    const SE3 T_G_plane = random_pose(random, 1.5, 5.0);
    PlaneFeature feature;
    feature.center_G = T_G_plane.t;
    feature.normal_G = T_G_plane.R.col(2);
    for (int j = 0; j < static_cast<int>(state.T_G_base.size()); ++j) {
      for (int i = 0; i < static_cast<int>(state.T_base_sensor.size()); ++i) {
        const SE3 T_sensor_G = state.T_G_sensor(j, i).inverse();
        std::vector<Vector3d> cloud;
        PlaneObservation o;
        o.stop = j;
        o.lidar = i;
        const Vector3d offset(random.normal(), random.normal(), 0.0);
        for (int k = 0; k < points; ++k) {
          const Vector3d p_plane =
              offset + Vector3d(0.5 * random.normal(), 0.5 * random.normal(), sigma * random.normal());
          cloud.push_back(T_sensor_G * (T_G_plane * p_plane));
          o.mean += cloud.back();
        }
        o.N = points;
        o.mean /= o.N;
        for (const Vector3d& p : cloud) o.scatter += (p - o.mean) * (p - o.mean).transpose();
        o.weight = sigma > 0.0 ? 1.0 / (sigma * sigma) : 1.0;
        feature.observations.push_back(o);
      }
    }
    features.push_back(feature);
  }
  return features;
}

}  // namespace rigcal
