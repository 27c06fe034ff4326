#pragma once

#include <cstdint>
#include <vector>

#include "core/base/error.h"
#include "core/rig/rig.h"
#include "simdata/lidar/beam_wobble.h"
#include "simdata/lidar/lidar_noise.h"
#include "simdata/lidar/prism_scanner.h"
#include "simdata/rig/turntable_motion.h"

namespace rigcal::sim {

/// How a simulated rig differs from what its rig file says.
struct MountError {
  double translation_m = 0.2;
  double rotation_deg = 10.0;
};

/// What real units have beyond noise; none of it by default.
struct UnitErrorOptions {
  double range_bias_sigma_m = 0.0;  ///< Each unit's own constant is drawn with this sigma.
  double dark_bias_m = 0.0;         ///< See LidarNoise::dark_bias; alike for all units.
  double wobble_rad = 0.0;          ///< Amplitude, see BeamWobble.
  double footprint_share = 0.2;     ///< See LidarNoise::second_ray_share; 1 is the real sensor, at half the speed.
};

/// AVIA as base looking forward, three MID-40 looking backward (yaw 180 + 30, 0, -30 deg, 0.15 m behind and 0.1 m
/// below): the rig in memory where no rig file is asked for.
[[nodiscard]] Rig nominal_rig();

/// One LiDAR of a simulated rig, with its scan and errors.
struct SimulatedLidar {
  int sensor = 0;  ///< Index in the rig.
  SE3 T_base_sensor;
  PrismScanner scanner;
  LidarNoise noise;
  BeamWobble wobble;
};

/// Everything that is drawn once a run: the true mounting, where the prisms stand, the motion.
struct SimulatedRig {
  std::vector<SE3> T_base_sensor;      ///< Truth of each sensor of the rig, cameras too.
  std::vector<SimulatedLidar> lidars;  ///< In the order of the rig.
  TurntableMotion motion;
};

/// Mounts every sensor at its initial extrinsic changed by exactly `error` in a random direction; a sensor without one
/// at a random place within 0.3 m, upright to 10 degrees, looking anywhere around. Errors: a LiDAR model without a
/// known scan pattern.
[[nodiscard]] Expected<SimulatedRig> make_simulated_rig(const Rig& rig, const SE3& T_scene_table,
                                                        const TurntableOptions& turntable, const MountError& error,
                                                        std::uint64_t seed, const UnitErrorOptions& unit_errors = {});

}  // namespace rigcal::sim
