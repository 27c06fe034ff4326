#pragma once

#include <string>
#include <vector>

#include "core/base/random.h"
#include "core/pipeline/lidar_calibration.h"
#include "simdata/rig/light_rig.h"

namespace rigcal::targetless {

struct SetOptions {
  std::string scene = "courtyard";
  Rig rig = sim::nominal_rig();  ///< LiDARs only.
  std::uint64_t seed = 1;
  int points = 20000;  ///< Of a patch.
  int stops = 20;
  /// How far the rough poses of the stops are off, as an odometry leaves them: sigma of each axis.
  double pose_error_m = 0.02;
  double pose_error_deg = 0.2;
  double drive_m = 0.0;   ///< See sim::TurntableOptions; 0: a turntable.
  double wander_m = 0.0;  ///< See sim::let_wander; 0: it does not.
  double wander_deg = 0.0;
};

/// One simulated run, with rough poses of its stops.
struct SimulatedSet {
  std::string scene;
  sim::LightRig light;         ///< The truth; its points are in `patches`.
  std::vector<Patch> patches;  ///< What methods that go by points take.
  LidarRecording recording;    ///< What ours takes; its trajectory are the rough poses.

  /// Where a method starts: the rough poses and these extrinsics.
  [[nodiscard]] RigState start(const std::vector<SE3>& T_base_sensor) const;
};

/// A pose as an odometry leaves it, off by the options' sigmas.
[[nodiscard]] SE3 rough_pose(const SE3& T, const SetOptions& options, Random& random);

/// Errors: the scene.
[[nodiscard]] Expected<SimulatedSet> make_set(const SetOptions& options, const sim::Scene& scene);

/// The true extrinsics of all LiDARs but the base, turned and shifted about and along each axis by anything up to
/// `rotation_deg` and `translation_m`, all alike likely. So drawn, 10 degrees and 0.2 m have the means and spreads that
/// the paper gives for them.
[[nodiscard]] std::vector<SE3> spoiled(const SimulatedSet& set, double rotation_deg, double translation_m,
                                       Random& random);

/// How far extrinsics are off: means over the LiDARs without the base, and the worst of them.
struct RigError {
  double rotation_rad = 0.0;
  double translation_m = 0.0;
  double worst_rotation_rad = 0.0;
  double worst_translation_m = 0.0;
};

[[nodiscard]] RigError error_of(const std::vector<SE3>& T_base_sensor, const SimulatedSet& set);

}  // namespace rigcal::targetless
