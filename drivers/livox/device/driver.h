#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "drivers/livox/device/control_loop.h"
#include "drivers/livox/device/doorbell.h"

namespace rigcal::livox {

struct DriverOptions {
  std::vector<WantedDevice> devices;
  std::string interface = "auto";  ///< Name of a network interface.
  std::string host_ip = "auto";
  bool bind_to_interface = false;         ///< Also keep the sockets to their interfaces; needs CAP_NET_RAW.
  std::size_t receive_bytes = 8U << 20U;  ///< Buffer of each data socket.
  /// Of each interface at which a device is heard: 48 MiB, 6 s of a rig of 5500 packets a second.
  std::size_t queue_datagrams = 1U << 15U;
  std::uint16_t discovery_port = kDiscoveryPort;
  bool send_utc = false;  ///< Each second tell devices that have a PPS what time it is, by this machine's clock.
  bool realtime = false;
  bool lock_memory = false;
};

/// What the driver knows of one device.
struct DeviceReport {
  LinkInfo link;
  std::uint64_t packets = 0;
  std::uint64_t bytes = 0;
  std::int64_t last_packet_ns = 0;  ///< Session time; 0: none yet.
};

/// What the driver knows of one interface.
struct InterfaceReport {
  net::Interface interface;
  std::size_t receive_bytes = 0;  ///< As given.
  std::size_t queue_high_water = 0;
  std::size_t queue_capacity = 0;
  ReceiverCounters counters;
};

/// Live Livox LiDARs: finds, takes and sets up the devices that are wanted, keeps them, and hands out every datagram,
/// of both directions. One thread talks to the devices; one for each interface takes their packets, and asks for no
/// memory once a device was heard there. All queues are bounded, and each datagram that is lost here is counted where
/// it is lost
/// (`interfaces`, `ControlLoop::counters`).
class Driver {
 public:
  /// Starts at once. Errors (kind system): no interface, a port that is taken.
  [[nodiscard]] static Expected<std::unique_ptr<Driver>> start(const DriverOptions& options);
  /// As `stop`.
  ~Driver();
  Driver(const Driver&) = delete;
  Driver& operator=(const Driver&) = delete;

  /// The oldest datagram that waits, for at most that long; false where none came, or nothing comes any more. It lives
  /// until the next call. Stamps are session time; each interface's own are in order. One thread only.
  bool next(Datagram& datagram, std::int64_t timeout_ns);

  /// Stops sampling, frees the devices (a second at most) and ends the threads. What is queued can still be taken.
  void stop();
  [[nodiscard]] bool is_running() const { return is_running_.load(); }

  [[nodiscard]] ControlLoop& control() { return *control_; }
  [[nodiscard]] std::vector<DeviceReport> devices() const;
  [[nodiscard]] std::vector<InterfaceReport> interfaces() const;
  /// Datagrams of control so far, both directions.
  [[nodiscard]] std::uint64_t control_datagrams() const { return control_->ring().pushed(); }
  /// Datagrams of control that nobody took from their queue in time.
  [[nodiscard]] std::uint64_t dropped_control() const { return control_->ring().dropped(); }
  /// Of its threads.
  [[nodiscard]] std::vector<const Heartbeat*> heartbeats() const;
  /// What is less good than it could be (buffers, priority), each a sentence with its mend.
  [[nodiscard]] std::vector<std::string> notes() const;
  /// The session clock's start: CLOCK_REALTIME and CLOCK_MONOTONIC together.
  [[nodiscard]] const net::ClockReading& session_start() const { return session_start_; }

 private:
  Driver() = default;
  void run_receiver(std::size_t index);
  bool take_oldest(Datagram& datagram);

  DriverOptions options_;
  net::ClockReading session_start_;
  Senders senders_;
  std::vector<net::Interface> hosts_;
  std::vector<std::unique_ptr<Receiver>> receivers_;
  std::unique_ptr<ControlLoop> control_;
  std::vector<std::thread> threads_;
  std::thread control_thread_;
  std::atomic<bool> is_running_{false};
  std::atomic<bool> is_receiving_{false};
  Doorbell doorbell_;                   ///< Of the thread that takes the datagrams.
  DatagramRing* taken_from_ = nullptr;  ///< Where the datagram that was handed out still lies.
  std::vector<std::string> notes_;
  std::vector<std::string> thread_notes_;  ///< By receiver, written before `started_` counts it.
  std::atomic<std::size_t> started_{0};
};

}  // namespace rigcal::livox
