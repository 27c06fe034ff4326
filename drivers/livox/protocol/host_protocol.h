#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "drivers/livox/protocol/device_link.h"

namespace rigcal::livox {

constexpr std::size_t kMaxDevices = 32;
constexpr std::size_t kMaxHosts = 16;
constexpr std::size_t kMaxSightings = 64;

/// A device that was heard, whoever wants it.
struct Sighting {
  Broadcast broadcast;
  Ipv4 ip{};
  std::size_t host = 0;            ///< Where it was heard last.
  std::size_t device = kNoDevice;  ///< Index in the list of wanted ones.
  std::int64_t first_ns = 0;
  std::int64_t last_ns = 0;
  std::uint64_t broadcasts = 0;
};

struct ProtocolCounters {
  std::uint64_t malformed = 0;  ///< Datagrams that are no control frame.
  std::uint64_t strangers = 0;  ///< Frames from addresses of no device that is connected or being connected.
};

/// The host's end of the connections with all devices of a rig, as a pure state machine: datagrams and time in, frames
/// to send and events out. It finds the wanted devices by their broadcasts, takes and sets them up, keeps them with
/// heartbeats, takes them again after losses, and frees them. The three units of a Mid-100 are three devices.
///
/// Times are of any one clock and must not run backwards (earlier ones count as the latest). Nothing blocks, nothing is
/// shared; a call appends at most a few frames and events for each device.
class HostProtocol {
 public:
  /// Errors: no host or device, more than `kMaxHosts` or `kMaxDevices`, a device without code and address, one named
  /// twice.
  [[nodiscard]] static Expected<HostProtocol> create(std::vector<HostAddress> hosts, std::vector<WantedDevice> devices);

  /// A datagram that came in on the interface of `host`, on the discovery or the command port. Any bytes are safe.
  void receive(std::int64_t now_ns, std::size_t host, const Endpoint& from, ByteView bytes, ProtocolOutput& out);
  /// A datagram that came in for discovery on an interface without a host address: a wanted device there is told of
  /// once.
  void receive_elsewhere(std::int64_t now_ns, const std::string& interface, const Endpoint& from, ByteView bytes,
                         ProtocolOutput& out);
  /// To be called at `deadline_ns`, or more often.
  void tick(std::int64_t now_ns, ProtocolOutput& out);
  [[nodiscard]] std::optional<std::int64_t> deadline_ns() const;

  /// Asks a device for something; the answer comes as RequestEnded. Sampling, power modes and heartbeats have their own
  /// ways. Errors: no such device, or it is not connected; its model does not know this; too many requests wait.
  Expected<void> request(std::int64_t now_ns, std::size_t device, ControlPayload request, ProtocolOutput& out);
  /// To be called 10 to 500 ms after each pulse: tells the devices that have one (PPS) what time it was then.
  void tell_utc(std::int64_t unix_ns, ProtocolOutput& out);
  void set_sampling(std::int64_t now_ns, std::size_t device, bool on, ProtocolOutput& out);
  void set_power(std::int64_t now_ns, std::size_t device, PowerMode mode, ProtocolOutput& out);
  /// Stops sampling and frees all devices; over when `is_closed`, after `kLeaveNs` at the latest.
  void leave(std::int64_t now_ns, ProtocolOutput& out);
  [[nodiscard]] bool is_closed() const;

  [[nodiscard]] std::size_t device_count() const { return links_.size(); }
  [[nodiscard]] const LinkInfo& device(std::size_t index) const { return links_[index].info(); }
  [[nodiscard]] const WantedDevice& wanted(std::size_t index) const { return links_[index].wanted(); }
  /// The latest `kMaxSightings` devices.
  [[nodiscard]] const std::vector<Sighting>& sightings() const { return sightings_; }
  [[nodiscard]] const ProtocolCounters& counters() const { return counters_; }

 private:
  HostProtocol(std::vector<HostAddress> hosts, std::vector<WantedDevice> devices);
  [[nodiscard]] std::int64_t forward(std::int64_t now_ns);
  void receive_broadcast(std::int64_t now_ns, std::size_t host, const Endpoint& from, const ControlFrame& frame,
                         ProtocolOutput& out);
  [[nodiscard]] std::size_t find_wanted(const Broadcast& broadcast, const Ipv4& ip) const;
  /// True where this is news.
  bool note_sighting(const Sighting& sighting);

  std::vector<HostAddress> hosts_;
  std::vector<DeviceLink> links_;
  std::vector<bool> is_told_elsewhere_;  ///< By device.
  std::vector<Sighting> sightings_;
  ProtocolCounters counters_;
  std::int64_t now_ns_ = INT64_MIN;
};

}  // namespace rigcal::livox
