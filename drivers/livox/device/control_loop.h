#pragma once

#include <atomic>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "core/base/heartbeat.h"
#include "drivers/livox/device/datagram_ring.h"
#include "drivers/livox/device/receiver.h"
#include "drivers/livox/protocol/host_protocol.h"
#include "drivers/net/interfaces.h"

namespace rigcal::livox {

/// What of the talk with the devices got lost here or was of no use, by reason.
struct ControlCounters {
  ProtocolCounters protocol;
  std::uint64_t receive_errors = 0;     ///< The system refused to receive, for example while the interface was down.
  std::uint64_t dropped_by_kernel = 0;  ///< The buffer of a socket was full.
  std::uint64_t send_errors = 0;        ///< The system refused to send: no way there, or a firewall.
  std::uint64_t unsent = 0;             ///< It had no room for a frame, or nobody listened at its end.
  std::uint64_t lost_events = 0;        ///< Nobody took them in time.
};

/// The protocol on real sockets: one for discovery, one for the commands of each host address. One thread calls `run`;
/// everything else may be called from any thread.
class ControlLoop {
 public:
  struct Wiring {
    std::vector<net::Interface> hosts;
    std::vector<std::uint16_t> data_ports;  ///< By host.
    std::vector<WantedDevice> devices;
    std::uint16_t discovery_port = kDiscoveryPort;
    bool bind_to_interface = false;
    net::ClockReading session_start;
    bool send_utc = false;
    /// Called for a host before the first frame is sent from there: a device that is wanted was heard.
    std::function<void(std::size_t host)> prepare;
  };

  /// Errors: a port that is taken, what HostProtocol::create refuses.
  [[nodiscard]] static Expected<std::unique_ptr<ControlLoop>> open(Wiring wiring, Senders& senders);

  /// Until the devices are free after `leave`.
  void run();
  void leave();

  Expected<void> request(std::size_t device, ControlPayload request);
  void set_sampling(std::size_t device, bool on);
  void set_power(std::size_t device, PowerMode mode);

  /// Takes the events since the last call; at most `kMostEvents` are kept.
  [[nodiscard]] std::vector<Event> take_events();
  [[nodiscard]] std::vector<LinkInfo> links() const;
  [[nodiscard]] std::vector<Sighting> sightings() const;
  [[nodiscard]] ControlCounters counters() const;
  [[nodiscard]] const Heartbeat& heartbeat() const { return heartbeat_; }
  /// All control datagrams, in both directions.
  [[nodiscard]] DatagramRing& ring() { return ring_; }

  static constexpr std::size_t kMostEvents = 4096;

 private:
  ControlLoop(Wiring wiring, Senders& senders, HostProtocol protocol, net::UdpSocket discovery,
              std::vector<net::UdpSocket> commands, net::Waiter waiter);
  template <class Call>
  auto with_protocol(const Call& call);
  void hear(net::UdpSocket& socket, std::optional<std::size_t> host);
  void hand_out();
  void follow_interfaces(std::int64_t now_ns);
  void tell_utc(const net::ClockReading& now);

  Wiring wiring_;
  Senders& senders_;
  HostProtocol protocol_;
  net::UdpSocket discovery_;
  std::vector<net::UdpSocket> commands_;
  net::Waiter waiter_;
  net::ReceiveBatch batch_;
  net::SessionClock clock_;
  DatagramRing ring_;
  ProtocolOutput output_;
  Heartbeat heartbeat_{"commands to the LiDARs"};
  mutable std::mutex mutex_;      ///< Of the protocol, its output, the ring's writing end and the events.
  std::int64_t followed_ns_ = 0;  ///< When the interfaces were looked at last.
  std::int64_t utc_told_s_ = 0;   ///< The second of the last time of day that was sent.
  std::vector<bool> prepared_;    ///< By host.
  std::deque<Event> events_;
  ControlCounters counted_;  ///< But what the protocol and the sockets count.
};

}  // namespace rigcal::livox
