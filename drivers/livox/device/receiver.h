#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>

#include "core/base/heartbeat.h"
#include "drivers/livox/device/datagram_ring.h"
#include "drivers/livox/protocol/host_protocol.h"
#include "drivers/net/session_clock.h"
#include "drivers/net/udp_socket.h"
#include "drivers/net/waiter.h"

namespace rigcal::livox {

/// Whose packets are taken: the address at which each device was connected last. Written by one thread, read by others.
class Senders {
 public:
  /// An address is one device's: it is taken from any other.
  void set(std::size_t device, const Ipv4& ip) {
    const std::uint32_t packed = pack(ip);
    for (std::size_t i = 0; i < addresses_.size(); ++i)
      if (i != device && addresses_[i].load(std::memory_order_relaxed) == packed) clear(i);
    addresses_[device].store(packed, std::memory_order_relaxed);
  }
  void clear(std::size_t device) { addresses_[device].store(0, std::memory_order_relaxed); }
  /// Index of the device, or kNoDevice.
  [[nodiscard]] std::size_t find(const Ipv4& ip) const {
    const std::uint32_t wanted = pack(ip);
    if (wanted == 0) return kNoDevice;  // Stands for nobody below.
    for (std::size_t i = 0; i < addresses_.size(); ++i)
      if (addresses_[i].load(std::memory_order_relaxed) == wanted) return i;
    return kNoDevice;
  }

 private:
  static std::uint32_t pack(const Ipv4& ip) {
    return std::uint32_t{ip[0]} << 24U | std::uint32_t{ip[1]} << 16U | std::uint32_t{ip[2]} << 8U | ip[3];
  }
  std::array<std::atomic<std::uint32_t>, kMaxDevices> addresses_{};
};

/// What came from one device on one interface.
struct DeviceTraffic {
  std::atomic<std::uint64_t> packets{0};
  std::atomic<std::uint64_t> bytes{0};
  std::atomic<std::int64_t> last_ns{0};  ///< Session time of the latest.
};

/// Where datagrams of one interface got lost, each counted once.
struct ReceiverCounters {
  std::uint64_t received = 0;           ///< Handed on.
  std::uint64_t dropped_by_kernel = 0;  ///< The socket's buffer was full.
  std::uint64_t dropped_by_queue = 0;   ///< Nobody took them from the queue in time.
  std::uint64_t strangers = 0;          ///< From addresses at which no device was connected.
  std::uint64_t errors = 0;             ///< The system refused to receive, for example while the interface was down.
};

/// Packets are let gather while they flow: the kernel has stamped them, and a wake-up costs as much as ten or twenty.
constexpr std::int64_t kLongestPauseNs = 10'000'000;

/// How long to let them gather next time, when so many came after a pause and there is room for so many: as long that
/// about a quarter of the room is filled, so that oversleeping costs nothing; 0: not at all.
[[nodiscard]] std::int64_t gathering_pause_ns(std::int64_t pause_ns, std::size_t came, std::size_t room);

/// Takes the sample packets of one interface off their socket, stamps and queues them, and nothing else. After
/// `prepare` no memory is asked for.
class Receiver {
 public:
  /// Errors: see UdpSocket::open.
  [[nodiscard]] static Expected<std::unique_ptr<Receiver>> open(const net::UdpOptions& options, const Senders& senders,
                                                                const net::ClockReading& session_start,
                                                                std::size_t queue_datagrams);

  /// Takes the memory of the queue, 48 MiB or so: where no device is heard none is taken. From one thread, before a
  /// device sends; until then all packets are those of strangers.
  void prepare();
  /// Waits for packets, at most for that long, and queues what is there; while packets flow, it lets them gather for
  /// some milliseconds first, as far as the socket's buffer has room. No wait: 0. Whether there was anything.
  bool receive_some(std::int64_t timeout_ns);
  /// From any thread: ends a wait.
  void wake() const { waiter_.wake(); }

  [[nodiscard]] const net::UdpSocket& socket() const { return socket_; }
  [[nodiscard]] DatagramRing& ring() { return ring_; }
  [[nodiscard]] ReceiverCounters counters() const;
  /// Beats at each call of `receive_some`.
  [[nodiscard]] Heartbeat& heartbeat() { return heartbeat_; }
  [[nodiscard]] const DeviceTraffic& traffic(std::size_t device) const { return traffic_[device]; }

 private:
  Receiver(net::UdpSocket socket, net::Waiter waiter, const Senders& senders, const net::ClockReading& session_start,
           std::size_t queue_datagrams);
  [[nodiscard]] net::ClockReading read_clocks();  ///< What is stamped since is mapped by it.
  void queue(std::size_t count, const net::ClockReading& now);

  net::UdpSocket socket_;
  net::Waiter waiter_;
  const Senders& senders_;
  net::SessionClock clock_;
  std::int64_t empty_since_ns_;  ///< CLOCK_MONOTONIC: what is in the socket came later.
  net::ReceiveBatch batch_;
  DatagramRing ring_;
  std::size_t room_;  ///< Packets that may wait in the socket and in the ring.
  std::int64_t pause_ns_;
  Heartbeat heartbeat_;
  bool is_flowing_ = false;
  std::array<DeviceTraffic, kMaxDevices> traffic_;
  std::atomic<bool> is_prepared_{false};
  std::atomic<std::uint64_t> received_{0};
  std::atomic<std::uint64_t> kernel_drops_{0};
  std::atomic<std::uint64_t> strangers_{0};
  std::atomic<std::uint64_t> errors_{0};
};

}  // namespace rigcal::livox
