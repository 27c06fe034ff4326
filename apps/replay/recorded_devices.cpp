#include "apps/replay/recorded_devices.h"

#include <algorithm>

#include "apps/ingest/lidar_identity.h"
#include "core/base/text.h"
#include "drivers/livox_codec/control_payload.h"
#include "simdata/packets/sim_device.h"

namespace rigcal {
namespace {

constexpr std::uint8_t control_start = 0xAA;

/// Broadcasts of networks whose masks are not known end in 255, mostly: better no host than all of them.
bool is_one_host(const livox::Ipv4& ip) {
  constexpr std::uint8_t first_multicast = 224;
  return ip[0] != 0 && ip[0] < first_multicast && ip[3] != 255;
}

livox::DeviceType guess_type(const RecordedDevice& device) {
  switch (device.points.value_or(livox::DataType::cartesian_tagged)) {
    case livox::DataType::cartesian:
    case livox::DataType::spherical:
      return livox::DeviceType::mid40;
    default:
      return livox::DeviceType::avia;
  }
}

}  // namespace

RecordedDevice* RecordedDevices::find_or_add(const Endpoint& from) {
  const auto known = devices_.find(from.ip);
  if (known == devices_.end() && devices_.size() >= kMost) {
    has_overflowed_ = true;
    return nullptr;
  }
  RecordedDevice& device = devices_[from.ip];
  device.ip = from.ip;
  if (device.ports.size() < kMostPorts) device.ports.insert(from.port);
  return &device;
}

bool RecordedDevices::add(const Datagram& datagram) {
  if (!datagram.bytes.empty() && datagram.bytes[0] == control_start) {
    if (const auto frame = livox::parse_control_frame(datagram.bytes)) {
      if (livox::is_request(*frame)) return false;
      RecordedDevice* device = find_or_add(datagram.from);
      if (device == nullptr) return false;
      last_ns_ = datagram.stamp_ns;
      if (livox::is_broadcast(*frame)) {
        if (const auto broadcast = livox::parse_broadcast(*frame)) device->broadcast = *broadcast;
      } else if (livox::command_of(*frame) == livox::Command::device_information) {
        const auto payload = livox::decode_control(*frame);
        const auto* ack = payload ? std::get_if<livox::DeviceInformationAck>(&*payload) : nullptr;
        if (ack != nullptr && ack->ret == livox::ReturnCode::success) device->firmware = ack->value;
      }
      return true;
    }
  }
  const auto packet = livox::parse_sample_packet(datagram.bytes);
  if (!packet) {
    const auto known = devices_.find(datagram.from.ip);
    return known != devices_.end() && known->second.ports.contains(datagram.from.port);
  }
  RecordedDevice* device = find_or_add(datagram.from);
  if (device == nullptr) return false;
  if (device->point_packets + device->imu_packets == 0) device->first_status = packet->header.status;
  if (packet->header.data_type == livox::DataType::imu) {
    ++device->imu_packets;
  } else {
    ++device->point_packets;
    if (!device->points) device->points = packet->header.data_type;
  }
  if (is_one_host(datagram.to.ip) && hosts_.size() < kMostHosts) hosts_.insert(datagram.to.ip);
  if (!first_sample_ns_) first_sample_ns_ = datagram.stamp_ns;
  last_ns_ = datagram.stamp_ns;
  return true;
}

DeviceIdentity identity_of(const RecordedDevice& device, const Rig& rig) {
  if (device.broadcast) return {*device.broadcast, false};
  DeviceIdentity identity;
  identity.broadcast = {{}, guess_type(device), livox::kDevicePort};
  identity.is_guessed = true;
  if (const int sensor = sensor_by_ip(rig, device.ip); sensor >= 0) {
    const LidarSettings& lidar = *rig.sensors[static_cast<std::size_t>(sensor)].lidar;
    identity.broadcast.broadcast_code = lidar.broadcast_code;
    if (const auto type = livox::device_type(lidar.model)) {
      identity.broadcast.type = *type;
      identity.is_guessed = false;
    }
  }
  if (identity.broadcast.broadcast_code.empty())
    identity.broadcast.broadcast_code = sim::made_up_code(identity.broadcast.type, device.ip[3]);
  return identity;
}

Expected<livox::Ipv4> recorded_host(const std::set<livox::Ipv4>& hosts, const std::set<livox::Ipv4>& own) {
  if (hosts.size() == 1) return *hosts.begin();
  const char* mend = "say where to send by --to ADDRESS";
  if (hosts.empty()) return input_error("the recording does not tell to which host the LiDARs sent", {}, mend);
  std::vector<std::string> names;
  std::vector<livox::Ipv4> here;
  for (const livox::Ipv4& host : hosts) {
    names.push_back(to_string(host));
    if (own.contains(host)) here.push_back(host);
  }
  if (here.size() == 1) return here.front();
  return input_error("the LiDARs sent to several hosts (" + joined(names, ", ") + ")", {}, mend);
}

}  // namespace rigcal
