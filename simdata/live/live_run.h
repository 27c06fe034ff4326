#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "simdata/live/live_cameras.h"
#include "simdata/live/virtual_rack.h"
#include "simdata/packets/run_stream.h"

namespace rigcal::sim {

struct LiveOptions {
  RunOptions run;
  double speed = 1.0;
  bool loop = false;
  double patience_s = 3.0;  ///< Once a LiDAR is told to sample, the run waits so long for the others.
  ControlFaults control;
  std::vector<Incident> incidents;
  std::uint16_t discovery_port = livox::kDiscoveryPort;
  TimeSource time_source = TimeSource::none;  ///< Of all of them: pulses at the full seconds of this machine's UTC.
  VirtualLivoxOptions device;                 ///< Times of all of them; who they are comes from the rig.
  LiveCameraOptions cameras;
  std::string table;              ///< A link to a table's serial line that is to be made; empty: there is none.
  bool table_speaks_grbl = true;  ///< Otherwise plain words.
  double table_jams_s = -1.0;     ///< From this time of the run on it turns no more; below 0: never.
};

struct LiveSummary {
  int stops = 0;
  double seconds = 0.0;  ///< Of the run, as far as it went.
  std::uint64_t packets = 0;
  std::uint64_t bytes = 0;
  std::uint64_t unsent = 0;         ///< Of these: refused by the system.
  double latest_s = 0.0;            ///< How late the latest packet was sent.
  bool is_complete = false;         ///< The run came to its end.
  std::vector<FaultCounts> faults;  ///< By device, points and IMU together.
  std::vector<LiveCameraSummary> cameras;
};

/// Serves the LiDARs and the GigE cameras of a rig as virtual devices on the network, each on its own address, until
/// the run is over or the work is cancelled. The run begins when all LiDARs are told to sample, or some seconds after
/// the first was (without LiDARs: with the first camera), so that who takes all of them misses nothing. A table is one
/// that turns as the run does, whenever it is told to. Errors: what
/// simulate_run and LiveCameras refuse; an address that this machine does not have, a port that is taken.
[[nodiscard]] Expected<LiveSummary> serve_live(const Scene& scene, const Rig& rig, const LiveOptions& options,
                                               const RunContext& context);

}  // namespace rigcal::sim
