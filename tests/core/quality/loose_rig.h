#pragma once

#include <functional>

#include "core/planes/adjust.h"
#include "tests/support/make_planes.h"

namespace rigcal {

/// Three LiDARs that see planes all around at some stops, solved. The last of them sits loosely: at each stop it stands
/// at T_base_sensor mount(stop).
struct LooseRig {
  static constexpr int lidars = 3;
  static constexpr double sigma_m = 0.01;

  RigState truth;
  RigState state;
  std::vector<PlaneFeature> features;
  ParameterLayout layout;
  AdjustOptions options;

  LooseRig(int stops, int planes, Random& random, const std::function<SE3(int)>& mount) : layout(stops, lidars) {
    truth.T_G_base.emplace_back();
    for (int j = 1; j < stops; ++j) truth.T_G_base.push_back(random_pose(random, 0.6, 0.2));
    truth.T_base_sensor = {SE3{}, random_pose(random, 0.8, 0.2), random_pose(random, 0.8, 0.2)};
    features = make_plane_features(truth, planes, 60, sigma_m, random);
    for (PlaneFeature& feature : features) {
      for (PlaneObservation& o : feature.observations) {
        o.offset_variance = sigma_m * sigma_m / o.N;
        const Vector3d n = truth.T_G_sensor(o.stop, o.lidar).R.transpose() * feature.normal_G;
        o.scatter -= o.N * sigma_m * sigma_m * n * n.transpose();
        if (o.lidar != lidars - 1) continue;
        // What it sees of a fixed world from there.
        const SE3 moved = mount(o.stop);
        o.mean = moved.inverse() * o.mean;
        o.scatter = moved.R.transpose() * o.scatter * moved.R;
      }
    }
    for (int j = 1; j < stops; ++j) layout.free_stop(j);
    for (int i = 1; i < lidars; ++i) layout.free_lidar(i);
    state = truth;
    adjust(features, layout, options, state);
  }
};

}  // namespace rigcal
