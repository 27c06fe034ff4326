#pragma once

#include "core/base/random.h"
#include "core/records/records.h"
#include "simdata/ray_caster.h"

namespace rigcal::sim {

/// How a LiDAR errs. One sigma unless said otherwise; ranges in metres.
struct LidarNoise {
  double range_sigma = 0.015;          ///< At the lens,
  double range_sigma_per_m = 0.25e-3;  ///< growing with range,
  double range_sigma_max = 0.04;       ///< up to this; at grazing incidence 1.3 times as much (the echo gets longer).
  double angle_sigma_rad = 0.0;        ///< Of the reported direction, in each of two directions across the ray.
  double min_range = 1.0;              ///< Nearer surfaces give no return.
  double max_range = 450.0;
  double range_at_10_percent = 190.0;  ///< Where half of the shots at a 10 % target return (data sheet).
  double lost_share = 0.002;           ///< Shots lost for no visible reason.
  double divergence_y_rad = 0.0;       ///< Full width of the beam along the sensor's y,
  double divergence_z_rad = 0.0;       ///< and along its z: the beam is much higher than wide.
  double second_ray_share = 0.2;       ///< Shots of which a second part of the footprint is looked at.
  double pulse_length = 0.75;  ///< Two surfaces in one footprint nearer together than this (5 ns) come as one point.

  /// 15 mm + 0.25 mm/m; directions 0.02 deg AVIA, 0.03 deg MID-40 (data sheets: below 0.05 and below 0.1 deg);
  /// divergence 0.03 x 0.28 deg; ranges from the data sheets.
  [[nodiscard]] static LidarNoise avia();
  [[nodiscard]] static LidarNoise mid40();
  /// No noise, no losses, no bleeding: for tests.
  [[nodiscard]] static LidarNoise none();

  [[nodiscard]] double range_sigma_at(double range, double cos_incidence) const;
};

/// One return of a shot; none where `range` is 0.
struct Echo {
  double range = 0.0;
  std::uint8_t reflectivity = 0;
  std::uint8_t tag = 0;  ///< Livox tag byte (return number; bits 0-1: likely a bleeding point).
};

/// What one shot measured. The second echo is that of another surface in the footprint, too far from the first to share
/// its pulse.
struct Shot {
  Vector3d direction = Vector3d::Zero();  ///< As reported, sensor frame.
  Echo first;
  Echo second;
};

/// Measures a scene: ray, footprint, losses and noise of one shot.
class ShotMeter {
 public:
  ShotMeter(const RayCaster& caster, const std::vector<Material>& materials, const LidarNoise& noise)
      : caster_(caster), materials_(materials), noise_(noise) {}

  /// `direction` is the true unit direction in the sensor frame, T_scene_sensor the pose at the moment of the shot.
  [[nodiscard]] Shot measure(const SE3& T_scene_sensor, const Vector3d& direction, const RayCaster::People& people,
                             Random& random) const;

 private:
  [[nodiscard]] bool is_lost(double range, double cos_incidence, double reflectivity, Random& random) const;
  /// Another part of the footprint: moves `first_range` and marks the first echo, or fills in the second.
  void look_again(const SE3& T_scene_sensor, const Vector3d& direction, const RayCaster::People& people, Random& random,
                  double& first_range, Shot& shot) const;
  /// Range with its noise and reflectivity with its own.
  void finish(Echo& echo, double range, double cos_incidence, double reflectivity, Random& random) const;

  const RayCaster& caster_;
  const std::vector<Material>& materials_;
  LidarNoise noise_;
};

/// The point of an echo as the wire carries it: whole millimetres.
[[nodiscard]] Point to_point(const Vector3d& direction, const Echo& echo);

}  // namespace rigcal::sim
