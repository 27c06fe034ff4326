#include <algorithm>
#include <utility>

#include "apps/replay/replay_outlet.h"
#include "core/base/seconds.h"
#include "drivers/net/udp_socket.h"
#include "drivers/net/waiter.h"

namespace rigcal {
namespace {

constexpr std::int64_t shortest_wait_ns = 200'000;  // Packets leave in small groups, not one by one.
constexpr std::int64_t longest_wait_ns = 50'000'000;

class PacketOutlet final : public ReplayOutlet {
 public:
  static Expected<std::unique_ptr<ReplayOutlet>> open(const RecordedDevices& devices, const ReplayPlaces& places,
                                                      const Rig& rig, const ReplayOptions& options) {
    auto waiter = net::Waiter::create({});
    if (!waiter) return waiter.error();
    auto outlet = std::unique_ptr<PacketOutlet>(new PacketOutlet(options, *std::move(waiter)));
    for (const auto& [ip, device] : devices.devices()) {
      outlet->devices_[ip] = {places.at(ip), ip, identity_of(device, rig).broadcast, 0, 0};
      for (const std::uint16_t port : device.ports) {
        auto socket = net::UdpSocket::open({{places.at(ip), port}, true, true, 0, {}});
        if (!socket) return place_error(socket.error());
        outlet->sockets_.emplace(Endpoint{ip, port}, *std::move(socket));
      }
    }
    return std::unique_ptr<ReplayOutlet>(std::move(outlet));
  }

  bool serve(std::int64_t) override { return true; }
  Expected<void> send(const Datagram& datagram, std::int64_t, const ReplayPace&) override {
    const auto socket = sockets_.find(datagram.from);
    if (socket == sockets_.end()) {
      ++left_out_;
      return {};
    }
    const std::uint16_t port = options_.to_port != 0 ? options_.to_port : datagram.to.port;
    const auto sent = socket->second.send({*options_.to, port}, datagram.bytes);
    if (!sent) return sent.error();
    ++devices_[datagram.from.ip].sent;
    ++datagrams_;
    bytes_ += datagram.bytes.size();
    if (!*sent) ++unsent_;
    return {};
  }
  void wait(std::int64_t until) override {
    waiter_.wait(std::clamp(until - monotonic_now_ns(), shortest_wait_ns, longest_wait_ns));
  }
  void finish(ReplaySummary& summary) override {
    summary.datagrams = datagrams_;
    summary.bytes = bytes_;
    summary.unsent = unsent_;
    summary.left_out += left_out_;
    for (const auto& [ip, device] : devices_) summary.devices.push_back(device);
  }

 private:
  PacketOutlet(const ReplayOptions& options, net::Waiter waiter) : options_(options), waiter_(std::move(waiter)) {}

  const ReplayOptions& options_;
  net::Waiter waiter_;
  std::map<Endpoint, net::UdpSocket> sockets_;
  std::map<livox::Ipv4, ReplayedDevice> devices_;
  std::uint64_t datagrams_ = 0;
  std::uint64_t bytes_ = 0;
  std::uint64_t unsent_ = 0;
  std::uint64_t left_out_ = 0;
};

}  // namespace

Error place_error(Error error) {
  error.mend =
      "give this machine the devices' addresses (sudo ip addr add ADDRESS/24 dev NAME), or let them appear on "
      "it by --network 127.0.0.0; end other programs that have the ports";
  return error;
}

Expected<std::unique_ptr<ReplayOutlet>> open_packet_outlet(const RecordedDevices& devices, const ReplayPlaces& places,
                                                           const Rig& rig, const ReplayOptions& options) {
  return PacketOutlet::open(devices, places, rig, options);
}

}  // namespace rigcal
