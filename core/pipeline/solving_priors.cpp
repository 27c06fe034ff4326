#include "core/pipeline/solving_priors.h"

namespace rigcal {
namespace {

// How far the start's poses may be off: groups of stops that share too little would slide apart along what is left
// open, and what holds them must be looser than any surface and tighter than metres.
constexpr double start_prior_m = 0.1;
constexpr double start_prior_rad = to_rad(1.0);

constexpr double guess_prior_m = 0.2;
constexpr double guess_prior_rad = to_rad(10.0);

}  // namespace

AdjustOptions solving_priors(const LidarRecording& recording, const Start& start,
                             const std::vector<std::optional<SE3>>& guess_T_base_sensor,
                             const LidarCalibrationOptions& options) {
  AdjustOptions priors;
  priors.lidar_matches.resize(recording.lidar_sensors.size());
  for (std::size_t i = 0; i < start.shape_matches.size(); ++i) {
    const auto& match = start.shape_matches[i];
    if (match) priors.lidar_matches[i] = prior_of(*match);
  }
  const bool given = recording.trajectory_is_prior;
  const double prior_rad = given ? options.pose_prior_rad : start_prior_rad;
  const double prior_m = given ? options.pose_prior_m : start_prior_m;
  priors.stop_priors.resize(recording.stops.size());
  for (std::size_t j = 0; j < recording.stops.size(); ++j) {
    if (given ? !recording.trajectory[j].has_value() : !start.stop_known[j]) continue;
    const SE3& T = given ? start.given_T_G_base[j] : start.state.T_G_base[j];
    priors.stop_priors[j] = isotropic_prior(T, prior_rad, prior_m);
  }
  if (!given) return priors;
  priors.lidar_priors.resize(recording.lidar_sensors.size());
  for (std::size_t i = 0; i < guess_T_base_sensor.size(); ++i) {
    const std::optional<SE3>& T = guess_T_base_sensor[i];
    if (T) priors.lidar_priors[i] = isotropic_prior(*T, guess_prior_rad, guess_prior_m);
  }
  return priors;
}

}  // namespace rigcal
