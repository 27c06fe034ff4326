#include <algorithm>
#include <cmath>
#include <utility>

#include "apps/replay/replay_outlet.h"
#include "simdata/live/virtual_rack.h"
#include "simdata/packets/sim_device.h"

namespace rigcal {
namespace {

class DeviceOutlet final : public ReplayOutlet {
 public:
  static Expected<std::unique_ptr<ReplayOutlet>> open(const RecordedDevices& devices, const ReplayPlaces& places,
                                                      const Rig& rig, const ReplayOptions& options,
                                                      Reporter& reporter) {
    std::vector<sim::RackDevice> placed;
    std::vector<Player> players;
    for (const auto& [ip, device] : devices.devices()) {
      if (device.point_packets + device.imu_packets == 0) continue;  // Only broadcast.
      const DeviceIdentity identity = identity_of(device, rig);
      const livox::Ipv4& at = places.at(ip);
      if (identity.is_guessed)
        reporter.warn(to_string(ip) + " does not say in the recording what it is: it appears as " +
                      livox::model_name(identity.broadcast.type) + " " + identity.broadcast.broadcast_code +
                      "; --rig RIG can say it");
      sim::VirtualLivoxOptions firmware;
      firmware.identity = identity.broadcast;
      firmware.ip = at;
      firmware.firmware = device.firmware;
      firmware.broadcast_to =
          sim::broadcast_address(at[0] == 127 ? livox::Ipv4{127, 0, 0, 1} : at, options.discovery_port);
      firmware.spin_up_s = options.spin_up_s;
      placed.push_back(
          {identity.broadcast.broadcast_code, firmware, {at, livox::kPointSourcePort}, {at, livox::kImuSourcePort}});
      players.push_back({{at, ip, identity.broadcast, 0, 0}, {}, 0});
    }
    auto rack = sim::VirtualRack::open(std::move(placed), {});
    if (!rack) return place_error(rack.error());
    for (std::size_t i = 0; i < players.size(); ++i) {
      const RecordedDevice& device = devices.devices().at(players[i].summary.recorded_ip);
      players[i].booted_ns = (*rack)->device(i).booted_ns();
      if (device.points) (*rack)->device(i).wake_with(*device.points, false);
      (*rack)->device(i).keep_echoes();
      (*rack)->device(i).report_status(device.first_status);
    }
    return std::unique_ptr<ReplayOutlet>(new DeviceOutlet(options, *std::move(rack), std::move(players)));
  }

  bool serve(std::int64_t now) override {
    rack_->serve(now);
    return rack_->may_begin(now, options_.patience_s);
  }
  Expected<void> send(const Datagram& datagram, std::int64_t due, const ReplayPace& pace) override {
    const auto packet = livox::parse_sample_packet(datagram.bytes);
    const auto player = std::find_if(players_.begin(), players_.end(), [&datagram](const Player& other) {
      return other.summary.recorded_ip == datagram.from.ip;
    });
    if (!packet || player == players_.end()) {
      ++left_out_;
      return {};
    }
    const auto index = static_cast<std::size_t>(player - players_.begin());
    sim::VirtualLivox& device = rack_->device(index);
    const bool imu = packet->header.data_type == livox::DataType::imu;
    device.report_status(packet->header.status);
    if (device.booted_ns() != player->booted_ns) {
      player->booted_ns = device.booted_ns();
      player->stamps.restart(std::max<std::int64_t>(0, due - device.booted_ns()));
    }
    bytes_.assign(datagram.bytes.begin(), datagram.bytes.end());
    player->stamps.rewrite(pace, datagram.stamp_ns, bytes_);
    if (!imu) change_coordinates(livox::record_layout(device.settings().point_type()).spherical, bytes_);
    ++(rack_->send(index, due, imu, bytes_) ? player->summary.sent : player->summary.not_wanted);
    return {};
  }
  void wait(std::int64_t until) override { rack_->wait(until); }
  void finish(ReplaySummary& summary) override {
    summary.datagrams = rack_->counts().packets;
    summary.bytes = rack_->counts().bytes;
    summary.unsent = rack_->counts().unsent;
    summary.left_out += left_out_;
    for (const Player& player : players_) summary.devices.push_back(player.summary);
  }

 private:
  struct Player {
    ReplayedDevice summary;
    ReplayStamps stamps;
    std::int64_t booted_ns = 0;
  };

  DeviceOutlet(const ReplayOptions& options, std::unique_ptr<sim::VirtualRack> rack, std::vector<Player> players)
      : options_(options), rack_(std::move(rack)), players_(std::move(players)) {}

  const ReplayOptions& options_;
  std::unique_ptr<sim::VirtualRack> rack_;
  std::vector<Player> players_;
  std::vector<std::uint8_t> bytes_;
  std::uint64_t left_out_ = 0;
};

}  // namespace

Expected<std::unique_ptr<ReplayOutlet>> open_device_outlet(const RecordedDevices& devices, const ReplayPlaces& places,
                                                           const Rig& rig, const ReplayOptions& options,
                                                           Reporter& reporter) {
  return DeviceOutlet::open(devices, places, rig, options, reporter);
}

}  // namespace rigcal
