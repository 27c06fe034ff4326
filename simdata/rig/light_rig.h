#pragma once

#include <cstdint>
#include <vector>

#include "core/base/error.h"
#include "core/records/records.h"
#include "core/rig/rig.h"
#include "simdata/rig/sim_rig.h"
#include "simdata/scene/scene.h"

namespace rigcal::sim {

struct LightRigOptions {
  std::uint64_t seed = 1;
  TurntableOptions turntable;  ///< Stops, dwell and the rest of the motion.
  UnitErrorOptions unit_errors;
  MountError mount_error;                 ///< How far the rig's initial extrinsics are off.
  int shots_per_patch = 20000;            ///< Spread evenly over the dwell; at most what the sensor fires in it.
  double step_rotation_sigma_deg = 0.02;  ///< Error of `step_rotations`, each axis.
  bool with_images = false;               ///< One of each camera and stop; only simulate_patches makes them.
  bool with_noise = true;                 ///< Without: exact points (but for the wire's millimetres), no losses.
};

/// When the patches of a stop are taken: in its dwell, as the still time before and after the run adds nothing, so that
/// all stops have the same share. A stop in which the rig is bumped is two, or one where what is left of it before or
/// after is no longer than the bump itself.
struct PatchTime {
  double start_s = 0.0;
  double length_s = 0.0;
  /// A rig that creeps is there on average.
  [[nodiscard]] double middle_s() const { return start_s + 0.5 * length_s; }
};
[[nodiscard]] std::vector<PatchTime> patch_times(const TurntableMotion& motion);

/// Patches of a turntable run and the truth about it, in memory: no packets, no files, for statistics over many runs.
struct LightRig {
  Rig rig;                                 ///< initial_T_base_sensor are off by the mount error.
  std::vector<Patch> patches;              ///< By stop, then by sensor; sensor frame, whole millimetres.
  std::vector<SimulatedLidar> lidars;      ///< Truth: mountings, noise and biases, in the order of the rig.
  std::vector<SE3> T_base_sensor;          ///< The same mountings by sensor.
  std::vector<SE3> T_G_base;               ///< Truth, by stop; the first is the identity.
  SE3 T_scene_G;                           ///< Where the base stands in the scene at the first stop.
  Vector3d axis = Vector3d::UnitZ();       ///< Of the table, in the base frame,
  Vector3d axis_point = Vector3d::Zero();  ///< and its point nearest to the base's origin.
  /// What the gyro says of the turn from stop k to k + 1: log(R_k^T R_k+1) with errors, base frame, rad.
  std::vector<Vector3d> step_rotations;
};

/// Renders the patches; every LiDAR stands still in the pose its stop settles to, but for creep and vibration where the
/// motion has them; people walk. The same bits for any number of threads.
[[nodiscard]] Expected<LightRig> make_light_rig(const Scene& scene, const LightRigOptions& options,
                                                const Rig& rig = nominal_rig());

}  // namespace rigcal::sim
