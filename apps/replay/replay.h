#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "apps/replay/recorded_devices.h"
#include "core/base/error.h"
#include "core/base/run_context.h"
#include "core/rig/rig.h"

namespace rigcal {

struct ReplayOptions {
  std::string input;  ///< A dump, an .lvx file or a session.
  std::string rig;    ///< Rig file, for devices that did not say in the recording who they are; empty: the session's.
  double speed = 1.0;
  bool loop = false;
  /// Devices appear in this network with the last numbers of their own addresses; nothing: where they were.
  std::optional<livox::Ipv4> network;

  // As plain packets:
  std::optional<livox::Ipv4> to;  ///< Nothing: the host of the recording.
  std::uint16_t to_port = 0;      ///< 0: as recorded.

  // As devices:
  bool as_devices = false;
  double spin_up_s = 2.0;
  double patience_s = 10.0;  ///< After the first device was started the others are waited for so long.
  std::uint16_t discovery_port = livox::kDiscoveryPort;
};

struct ReplayedDevice {
  livox::Ipv4 ip{};  ///< Where it appears.
  livox::Ipv4 recorded_ip{};
  livox::Broadcast broadcast;
  std::uint64_t sent = 0;
  std::uint64_t not_wanted = 0;  ///< Packets that a device did not send, as nobody had told it to sample.
};

struct ReplaySummary {
  double seconds = 0.0;  ///< Of the recording, all passes together.
  int passes = 0;        ///< That came to their end.
  bool is_complete = false;
  std::uint64_t datagrams = 0;
  std::uint64_t bytes = 0;
  std::uint64_t unsent = 0;    ///< Of these: refused by the system.
  std::uint64_t left_out = 0;  ///< Datagrams of the recording that no LiDAR sent, or, as devices, no samples.
  double latest_s = 0.0;       ///< How late the latest datagram left.
  std::string truncation;      ///< Where and why the recording ends too soon.
  std::vector<ReplayedDevice> devices;
};

/// Sends what the LiDARs of a recording sent, in its own time, until its end or until it is told to stop. As plain
/// packets it goes to one address, byte for byte; a warning names the recording's host where that is meant. As devices
/// each LiDAR waits for a host and does what it is told; the recording begins once all of them sample. Errors: nothing
/// to be read, no packets of a LiDAR, an address that this machine does not have, no way to the receiver, no host that
/// is known.
[[nodiscard]] Expected<ReplaySummary> replay(const ReplayOptions& options, const RunContext& context);

[[nodiscard]] std::string replay_text(const ReplayOptions& options, const ReplaySummary& summary);
/// As docs/schema/replay.json has it.
[[nodiscard]] std::string replay_json(const ReplayOptions& options, const ReplaySummary& summary);

}  // namespace rigcal
