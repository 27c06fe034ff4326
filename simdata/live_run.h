#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "simdata/run_stream.h"
#include "simdata/virtual_livox.h"

namespace rigcal::sim {

/// Something that happens to a device while it serves.
struct Incident {
  enum class Kind : std::uint8_t { reboot, silence, status, owned_by_other };
  std::string sensor;
  double time_s = 0.0;  ///< After the devices were switched on.
  Kind kind = Kind::reboot;
  double length_s = 0.0;     ///< Of a silence, or of another host's possession.
  std::uint32_t status = 0;  ///< The status word from then on.
};

struct LiveOptions {
  RunOptions run;
  double speed = 1.0;
  bool loop = false;
  ControlFaults control;
  std::vector<Incident> incidents;
  std::uint16_t discovery_port = livox::kDiscoveryPort;
  VirtualLivoxOptions device;  ///< Times of all of them; who they are comes from the rig.
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
};

/// Serves the LiDARs of a rig as virtual devices on the network, each on its own address, until the run is over or the
/// work is cancelled. The run begins when the first device is told to sample: whoever waits for it misses nothing but
/// what its slower devices miss. Errors: what simulate_run refuses; an address that this machine does not have, a port
/// that is taken.
[[nodiscard]] Expected<LiveSummary> serve_live(const Scene& scene, const Rig& rig, const LiveOptions& options,
                                               const RunContext& context);

}  // namespace rigcal::sim
