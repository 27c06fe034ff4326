#include "simdata/lidar/lidar_noise.h"

#include <algorithm>

#include "core/geometry/se3.h"

namespace rigcal::sim {

LidarNoise LidarNoise::of(LidarModel model) {
  const LidarFacts& facts = facts_of(model);
  LidarNoise noise;
  noise.angle_sigma_rad = to_rad(facts.angle_sigma_deg);
  noise.min_range = facts.min_range_m;
  noise.max_range = facts.max_range_m;
  noise.range_at_10_percent = facts.range_at_10_percent_m;
  noise.divergence_y_rad = to_rad(facts.beam_level_deg);
  noise.divergence_z_rad = to_rad(facts.beam_upright_deg);
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
