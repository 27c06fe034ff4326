#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "drivers/net/udp_socket.h"
#include "drivers/net/waiter.h"
#include "simdata/live/live_incident.h"
#include "simdata/live/virtual_livox.h"
#include "simdata/packets/packet_faults.h"

namespace rigcal::sim {

struct RackDevice {
  std::string name;  ///< As incidents name it.
  VirtualLivoxOptions firmware;
  Endpoint point_source;  ///< Where its packets come from; the control port is at the same address.
  Endpoint imu_source;
};

struct RackOptions {
  std::vector<Incident> incidents;
  FaultOptions packets;
  std::uint64_t seed = 1;  ///< Of the packets' faults.
};

/// What left a rack.
struct RackCounts {
  std::uint64_t packets = 0;
  std::uint64_t bytes = 0;
  std::uint64_t unsent = 0;  ///< Of the packets: refused by the system.
};

/// Virtual devices on sockets, each at its own address: their control sides live here, and what they stream is handed
/// in. One thread.
class VirtualRack {
 public:
  /// Switches the devices on. Errors: an address that this machine does not have, a port that is taken, an incident of
  /// a device that is not there, too many devices.
  [[nodiscard]] static Expected<std::unique_ptr<VirtualRack>> open(std::vector<RackDevice> devices,
                                                                   RackOptions options);

  /// Hears and answers hosts and lets incidents happen; to be called often.
  void serve(std::int64_t now_ns);
  /// Until a host speaks, a device wants to, or this time has come.
  void wait(std::int64_t until_ns);

  [[nodiscard]] std::size_t size() const { return units_.size(); }
  [[nodiscard]] VirtualLivox& device(std::size_t index) { return units_[index].control; }
  [[nodiscard]] bool is_any_sampling() const;
  [[nodiscard]] bool are_all_sampling() const;
  /// Whether all sample, or some have sampled for as long as one waits for the others; to be asked until it is true.
  [[nodiscard]] bool may_begin(std::int64_t now_ns, double patience_s);
  /// How far incidents have put a device's clock forward since its last start.
  [[nodiscard]] std::int64_t clock_shift_ns(std::size_t index) const { return units_[index].clock_shift_ns; }

  /// Sends a packet that is due then to the device's owner, through the faults; a device that nobody has, that does not
  /// sample or is silent sends none, and says false. What the system refuses is lost, as on any network, and counted.
  bool send(std::size_t index, std::int64_t due_ns, bool imu, ByteView bytes);
  /// The end: packets that faults hold back leave.
  void flush() { static_cast<void>(faults_.flush()); }  // `leave` never fails.

  [[nodiscard]] const RackCounts& counts() const { return counts_; }
  /// What was done to the packets of a device, points and IMU together.
  [[nodiscard]] FaultCounts faults(std::size_t index) const;

 private:
  struct Sockets {
    net::UdpSocket control;
    net::UdpSocket points;
    net::UdpSocket imu;
  };
  struct Unit {
    RackDevice device;
    Sockets sockets;
    VirtualLivox control;
    std::int64_t booted_ns = 0;
    std::int64_t clock_shift_ns = 0;
  };

  VirtualRack(std::vector<Unit> units, net::Waiter waiter, RackOptions options, std::int64_t now_ns);
  [[nodiscard]] static Expected<Sockets> open_sockets(const RackDevice& device);
  void happen(std::int64_t now_ns);
  void happen_once(const Incident& incident, Unit& unit, std::int64_t now_ns);
  void leave(const Datagram& datagram);

  std::vector<Unit> units_;
  net::Waiter waiter_;
  RackOptions options_;
  std::vector<bool> happened_;  ///< By incident.
  std::int64_t switched_on_ns_;
  std::optional<std::int64_t> first_sampling_ns_;
  net::ReceiveBatch batch_;
  std::vector<DeviceFrame> frames_;
  PacketFaults faults_;
  RackCounts counts_;
};

}  // namespace rigcal::sim
