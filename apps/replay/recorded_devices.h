#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <vector>

#include "core/base/error.h"
#include "core/records/records.h"
#include "core/rig/rig.h"
#include "drivers/livox_codec/discovery.h"
#include "drivers/livox_codec/general_commands.h"
#include "drivers/livox_codec/sample_packet.h"

namespace rigcal {

/// A LiDAR as a recording shows it.
struct RecordedDevice {
  livox::Ipv4 ip{};
  std::optional<livox::Broadcast> broadcast;       ///< As it told who it is.
  std::optional<livox::FirmwareVersion> firmware;  ///< As it answered.
  std::optional<livox::DataType> points;           ///< Of its first packet of points.
  std::uint32_t first_status = 0;                  ///< Of its first packet.
  std::set<std::uint16_t> ports;                   ///< Where it spoke from, at most `kMostPorts`.
  std::uint64_t point_packets = 0;
  std::uint64_t imu_packets = 0;
};

/// Finds out which LiDARs speak in a recording. Any bytes are safe, memory is bounded.
class RecordedDevices {
 public:
  static constexpr std::size_t kMost = 64;
  static constexpr std::size_t kMostPorts = 8;
  static constexpr std::size_t kMostHosts = 8;

  /// Whether the datagram is one of a LiDAR: a sample packet, an answer or a message of one, or anything else that
  /// comes from where such a one came before, as damaged packets do. Requests of hosts are none.
  bool add(const Datagram& datagram);

  /// By address.
  [[nodiscard]] const std::map<livox::Ipv4, RecordedDevice>& devices() const { return devices_; }
  [[nodiscard]] std::optional<std::int64_t> first_sample_ns() const { return first_sample_ns_; }
  /// Stamp of the last datagram of a device.
  [[nodiscard]] std::int64_t last_ns() const { return last_ns_; }
  /// The hosts to which samples went; addresses that stand for many machines, or for none, are no hosts.
  [[nodiscard]] const std::set<livox::Ipv4>& hosts() const { return hosts_; }
  /// Devices that were too many to be told apart.
  [[nodiscard]] bool has_overflowed() const { return has_overflowed_; }

 private:
  RecordedDevice* find_or_add(const Endpoint& from);

  std::map<livox::Ipv4, RecordedDevice> devices_;
  std::set<livox::Ipv4> hosts_;
  std::optional<std::int64_t> first_sample_ns_;
  std::int64_t last_ns_ = 0;
  bool has_overflowed_ = false;
};

/// Who a recorded device is when it is to be played: what it said of itself, else the rig file's sensor at its address,
/// else a guess by its packets.
struct DeviceIdentity {
  livox::Broadcast broadcast;
  bool is_guessed = false;
};
[[nodiscard]] DeviceIdentity identity_of(const RecordedDevice& device, const Rig& rig);

/// The host to which a recording's LiDARs sent, to send there again: the only one, or of several the only one that this
/// machine is (`own`: its addresses). Errors, without a place: none, or more than one that it may be.
[[nodiscard]] Expected<livox::Ipv4> recorded_host(const std::set<livox::Ipv4>& hosts, const std::set<livox::Ipv4>& own);

}  // namespace rigcal
