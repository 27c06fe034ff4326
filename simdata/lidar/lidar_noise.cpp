#include "simdata/lidar/lidar_noise.h"

#include <algorithm>

#include "core/geometry/se3.h"

namespace rigcal::sim {

LidarNoise LidarNoise::avia() {
  LidarNoise noise;
  noise.angle_sigma_rad = to_rad(0.02);
  noise.divergence_y_rad = to_rad(0.03);
  noise.divergence_z_rad = to_rad(0.28);
  return noise;
}

LidarNoise LidarNoise::mid40() {
  LidarNoise noise = avia();
  noise.angle_sigma_rad = to_rad(0.03);
  noise.max_range = 260.0;
  noise.range_at_10_percent = 90.0;
  return noise;
}

LidarNoise LidarNoise::of(LidarModel model) {
  LidarNoise noise = avia();
  switch (model) {
    case LidarModel::livox_avia:
    case LidarModel::other:
      break;
    case LidarModel::livox_mid40:
      return mid40();
    case LidarModel::livox_mid70:
      noise = mid40();
      noise.min_range = 0.05;
      break;
    case LidarModel::livox_horizon:
      noise.min_range = 0.5;
      noise.max_range = 260.0;
      noise.range_at_10_percent = 90.0;
      break;
    case LidarModel::livox_tele15:
      noise.angle_sigma_rad = to_rad(0.012);
      noise.divergence_y_rad = to_rad(0.02);
      noise.divergence_z_rad = to_rad(0.12);
      noise.min_range = 3.0;
      noise.max_range = 500.0;
      noise.range_at_10_percent = 320.0;
      break;
  }
  return noise;
}

LidarNoise LidarNoise::none() {
  LidarNoise noise;
  noise.range_sigma = noise.range_sigma_per_m = noise.range_sigma_max = 0.0;
  noise.min_range = 0.0;
  noise.lost_share = 0.0;
  noise.range_at_10_percent = 1e9;
  noise.second_ray_share = 0.0;
  return noise;
}

double LidarNoise::range_sigma_at(double range, double cos_incidence) const {
  const double straight = std::min(range_sigma + range_sigma_per_m * range, range_sigma_max);
  return straight * (1.0 + 0.3 * (1.0 - cos_incidence));
}

double LidarNoise::bias_at(double reflectivity) const {
  return range_bias + dark_bias * (1.0 - std::min(reflectivity, 100.0) / 100.0);
}

}  // namespace rigcal::sim
