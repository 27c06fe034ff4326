#pragma once

#include <cstdint>
#include <vector>

#include "core/base/error.h"
#include "core/base/run_context.h"
#include "core/records/records.h"
#include "core/rig/rig.h"
#include "simdata/packets/packet_faults.h"
#include "simdata/packets/packet_renderer.h"
#include "simdata/rig/sim_rig.h"
#include "simdata/scene/scene.h"

namespace rigcal::sim {

struct RunOptions {
  std::uint64_t seed = 1;
  TurntableOptions turntable;
  MountError mount_error;
  UnitErrorOptions unit_errors;
  PacketPath path;
  double clock_drift_ppm = usual_clock_drift_ppm;  ///< Clocks of the devices are up to so much too fast or too slow.
  FaultOptions faults;
  int images_per_stop = 0;                            ///< Of each camera; only simulate_session makes them.
  std::int64_t start_ns = 1'700'000'000'000'000'000;  ///< Session time of the first broadcast (November 2023).
};

/// What is true about a simulated run.
struct RunTruth {
  std::int64_t start_ns = 0;               ///< Session time of the first datagram,
  std::int64_t sampling_ns = 0;            ///< of true time 0, when sampling began,
  std::int64_t end_ns = 0;                 ///< and of the end.
  std::vector<SE3> T_base_sensor;          ///< By sensor of the rig.
  std::vector<Stop> stops;                 ///< A stop in which the rig was bumped is two.
  std::vector<SE3> T_G_base;               ///< By stop: without swing and vibration, in its middle.
  Vector3d axis = Vector3d::UnitZ();       ///< Of the table, in the base frame,
  Vector3d axis_point = Vector3d::Zero();  ///< and its point nearest to the base's origin.
  std::vector<SimDevice> devices;
  std::vector<SimulatedLidar> lidars;      ///< By device: noise and biases.
  std::vector<ImuErrors> imu_errors;       ///< By device; zero where it has no IMU.
  std::vector<FaultCounts> point_packets;  ///< By device: what it sent, and what became of it on the way.
  std::vector<FaultCounts> imu_packets;
};

/// Simulates a whole turntable run: two seconds in which each device broadcasts, then sample packets of all devices
/// without a break, also while the table turns, and IMU packets; handed to `sink` in the order of the host's stamps,
/// from this thread. Rendering uses all threads and gives the same bits for any number of them.
/// Errors: what make_devices and make_simulated_rig refuse, the sink's, and cancellation.
[[nodiscard]] Expected<RunTruth> simulate_run(const Scene& scene, const Rig& rig, const RunOptions& options,
                                              const DatagramSink& sink, const RunContext& context);

}  // namespace rigcal::sim
