#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/io/ground_truth.h"
#include "core/rig/camera_model.h"
#include "simdata/camera/exposure_plan.h"
#include "simdata/camera/image_sensor.h"
#include "simdata/rig/sim_rig.h"

/// The cameras of a simulated run and when they expose, for images on disk and on the network alike.
namespace rigcal::sim {

struct SimulatedCamera {
  int sensor = 0;  ///< Index in the rig.
  std::string name;
  ImageSensor chip;
  SE3 T_base_camera;
  CameraModel model;
  bool triggered = false;
  double delay_s = 0.0;  ///< From the beginning of a pulse to the exposure.

  [[nodiscard]] double exposure_s() const { return chip.exposure_us * 1e-6; }
  [[nodiscard]] double begin_s(const ExposurePulse& pulse) const { return pulse.time_s + delay_s; }
  [[nodiscard]] double middle_s(const ExposurePulse& pulse) const { return begin_s(pulse) + 0.5 * exposure_s(); }
  /// Which noise the camera's frame of that number has.
  [[nodiscard]] std::uint64_t noise_of(std::uint64_t frame) const;
};

/// The cameras that have intrinsics. `T_base_sensor`: truth, by sensor. Errors: a pixel format that is not known.
[[nodiscard]] Expected<std::vector<SimulatedCamera>> simulated_cameras(const Rig& rig,
                                                                       const std::vector<SE3>& T_base_sensor);

/// `per_stop` pulses in every stop once it has settled; each of them leaves time for the camera that needs longest.
[[nodiscard]] std::vector<ExposurePulse> plan_exposures(const std::vector<SimulatedCamera>& cameras,
                                                        const TurntableMotion& motion, int per_stop);

/// A camera's clock, which counts from when it was switched on: how much it has counted when the run begins, and its
/// drift.
[[nodiscard]] ClockTruth camera_clock(std::uint64_t seed, int sensor);

}  // namespace rigcal::sim
