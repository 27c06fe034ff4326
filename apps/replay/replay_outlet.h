#pragma once

#include <map>
#include <memory>

#include "apps/replay/recorded_devices.h"
#include "apps/replay/replay.h"
#include "apps/replay/replay_stamps.h"

namespace rigcal {

/// Where what a recording's LiDARs sent leaves this machine.
class ReplayOutlet {
 public:
  ReplayOutlet() = default;
  ReplayOutlet(const ReplayOutlet&) = delete;
  ReplayOutlet& operator=(const ReplayOutlet&) = delete;
  virtual ~ReplayOutlet() = default;

  /// To be called often. Whether the recording is to run.
  [[nodiscard]] virtual bool serve(std::int64_t now_ns) = 0;
  /// Takes a datagram that is due then. Errors: no way there.
  virtual Expected<void> send(const Datagram& datagram, std::int64_t due_ns, const ReplayPace& pace) = 0;
  /// Until then, or until `serve` has something to do.
  virtual void wait(std::int64_t until_ns) = 0;
  /// What became of it all.
  virtual void finish(ReplaySummary& summary) = 0;
};

/// Where each device appears, by its recorded address.
using ReplayPlaces = std::map<livox::Ipv4, livox::Ipv4>;

/// All to one address, byte for byte, each LiDAR from its own. `options` must outlive the outlet. Errors: an address
/// that this machine does not have.
[[nodiscard]] Expected<std::unique_ptr<ReplayOutlet>> open_packet_outlet(const RecordedDevices& devices,
                                                                         const ReplayPlaces& places, const Rig& rig,
                                                                         const ReplayOptions& options);

/// Virtual devices that send what was recorded of them, as their hosts tell them to. Who does not say in the recording
/// what it is is guessed, with a warning. `options` must outlive the outlet. Errors: an address that this machine does
/// not have, a port that is taken.
[[nodiscard]] Expected<std::unique_ptr<ReplayOutlet>> open_device_outlet(const RecordedDevices& devices,
                                                                         const ReplayPlaces& places, const Rig& rig,
                                                                         const ReplayOptions& options,
                                                                         Reporter& reporter);

/// The error of a socket at a device's address, with what helps: nearly always the address is missing.
[[nodiscard]] Error place_error(Error error);

}  // namespace rigcal
