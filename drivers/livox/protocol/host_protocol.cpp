#include "drivers/livox/protocol/host_protocol.h"

#include <algorithm>
#include <utility>

namespace rigcal::livox {
namespace {

bool is_same_subnet(const HostAddress& host, const Ipv4& ip) {
  for (std::size_t i = 0; i < ip.size(); ++i)
    if (((ip[i] ^ host.ip[i]) & host.mask[i]) != 0) return false;
  return true;
}

std::string name_of(const WantedDevice& device) {
  return device.broadcast_code.empty() && device.ip ? rigcal::to_string(*device.ip) : device.broadcast_code;
}

}  // namespace

Expected<HostProtocol> HostProtocol::create(std::vector<HostAddress> hosts, std::vector<WantedDevice> devices) {
  if (hosts.empty() || hosts.size() > kMaxHosts)
    return input_error(std::to_string(hosts.size()) + " addresses of this host", "Livox protocol",
                       "give 1 to " + std::to_string(kMaxHosts));
  if (devices.empty() || devices.size() > kMaxDevices)
    return input_error(std::to_string(devices.size()) + " devices", "Livox protocol",
                       "give 1 to " + std::to_string(kMaxDevices));
  for (std::size_t i = 0; i < devices.size(); ++i) {
    if (devices[i].broadcast_code.empty() && !devices[i].ip)
      return input_error("a device has neither a broadcast code nor an address", "Livox protocol", "add one of them");
    for (std::size_t k = 0; k < i; ++k)
      if (name_of(devices[k]) == name_of(devices[i]))
        return input_error("the device " + name_of(devices[i]) + " is named twice", "Livox protocol",
                           "take one of them away");
  }
  return HostProtocol(std::move(hosts), std::move(devices));
}

HostProtocol::HostProtocol(std::vector<HostAddress> hosts, std::vector<WantedDevice> devices)
    : hosts_(std::move(hosts)), is_told_elsewhere_(devices.size(), false) {
  links_.reserve(devices.size());
  for (WantedDevice& device : devices) links_.emplace_back(links_.size(), std::move(device));
  sightings_.reserve(kMaxSightings);
}

std::int64_t HostProtocol::forward(std::int64_t now_ns) { return now_ns_ = std::max(now_ns_, now_ns); }

void HostProtocol::receive(std::int64_t now_ns, std::size_t host, const Endpoint& from, ByteView bytes,
                           ProtocolOutput& out) {
  RIGCAL_ASSERT(host < hosts_.size(), "a host address that is not in the list");
  const std::int64_t now = forward(now_ns);
  const auto frame = parse_control_frame(bytes);
  if (!frame) {
    ++counters_.malformed;
    return;
  }
  if (is_broadcast(*frame)) return receive_broadcast(now, host, from, *frame, out);
  const auto link = std::find_if(links_.begin(), links_.end(), [&from](const DeviceLink& candidate) {
    return candidate.is_addressed() && candidate.info().ip == from.ip;
  });
  if (link == links_.end()) {
    ++counters_.strangers;
    return;
  }
  link->receive_frame(now, *frame, out);
}

void HostProtocol::receive_broadcast(std::int64_t now_ns, std::size_t host, const Endpoint& from,
                                     const ControlFrame& frame, ProtocolOutput& out) {
  const auto broadcast = parse_broadcast(frame);
  if (!broadcast) {
    ++counters_.malformed;
    return;
  }
  const std::size_t device = find_wanted(*broadcast, from.ip);
  const bool news = note_sighting({*broadcast, from.ip, host, device, now_ns, now_ns, 1});
  if (news) out.events.push_back({now_ns, device, Seen{*broadcast, from.ip}});
  const auto other = std::find_if(links_.begin(), links_.end(), [&](const DeviceLink& link) {
    return link.is_addressed() && link.info().ip == from.ip &&
           link.info().broadcast.broadcast_code != broadcast->broadcast_code;
  });
  if (other != links_.end()) {
    const auto index = static_cast<std::size_t>(other - links_.begin());
    if (news) out.events.push_back({now_ns, index, AddressConflict{*broadcast, from.ip}});
    return;  // Its frames could not be told from the other's.
  }
  if (device == kNoDevice) return;
  if (!is_same_subnet(hosts_[host], from.ip)) {
    if (news) out.events.push_back({now_ns, device, Unreachable{*broadcast, from.ip}});
    return;
  }
  links_[device].receive_broadcast(now_ns, *broadcast, from, hosts_[host], host, out);
}

void HostProtocol::receive_elsewhere(std::int64_t now_ns, const std::string& interface, const Endpoint& from,
                                     ByteView bytes, ProtocolOutput& out) {
  const std::int64_t now = forward(now_ns);
  const auto frame = parse_control_frame(bytes);
  if (!frame || !is_broadcast(*frame)) return;
  const auto broadcast = parse_broadcast(*frame);
  if (!broadcast) return;
  const std::size_t device = find_wanted(*broadcast, from.ip);
  if (device == kNoDevice || links_[device].is_connected() || is_told_elsewhere_[device]) return;
  is_told_elsewhere_[device] = true;
  out.events.push_back({now, device, HeardElsewhere{*broadcast, from.ip, interface}});
}

std::size_t HostProtocol::find_wanted(const Broadcast& broadcast, const Ipv4& ip) const {
  if (broadcast.type == DeviceType::hub) return kNoDevice;
  auto found = std::find_if(links_.begin(), links_.end(), [&](const DeviceLink& link) {
    return link.wanted().broadcast_code == broadcast.broadcast_code;
  });
  if (found == links_.end()) {
    found = std::find_if(links_.begin(), links_.end(), [&](const DeviceLink& link) {
      return link.wanted().broadcast_code.empty() && link.wanted().ip == ip;
    });
  }
  return found == links_.end() ? kNoDevice : static_cast<std::size_t>(found - links_.begin());
}

bool HostProtocol::note_sighting(const Sighting& sighting) {
  const auto same = std::find_if(sightings_.begin(), sightings_.end(), [&sighting](const Sighting& known) {
    return known.broadcast.broadcast_code == sighting.broadcast.broadcast_code;
  });
  if (same != sightings_.end()) {
    const bool moved = same->ip != sighting.ip || same->host != sighting.host;
    same->broadcast = sighting.broadcast;
    same->ip = sighting.ip;
    same->host = sighting.host;
    same->device = sighting.device;
    same->last_ns = sighting.last_ns;
    ++same->broadcasts;
    return moved;
  }
  if (sightings_.size() < kMaxSightings) {
    sightings_.push_back(sighting);
  } else {
    *std::min_element(sightings_.begin(), sightings_.end(),
                      [](const Sighting& a, const Sighting& b) { return a.last_ns < b.last_ns; }) = sighting;
  }
  return true;
}

void HostProtocol::tick(std::int64_t now_ns, ProtocolOutput& out) {
  const std::int64_t now = forward(now_ns);
  for (DeviceLink& link : links_) link.tick(now, out);
}

std::optional<std::int64_t> HostProtocol::deadline_ns() const {
  std::optional<std::int64_t> earliest;
  for (const DeviceLink& link : links_) {
    const auto deadline = link.deadline_ns();
    if (deadline && (!earliest || *deadline < *earliest)) earliest = deadline;
  }
  return earliest;
}

Expected<void> HostProtocol::request(std::int64_t now_ns, std::size_t device, ControlPayload request,
                                     ProtocolOutput& out) {
  if (device >= links_.size()) return input_error("there is no device " + std::to_string(device), "Livox protocol");
  return links_[device].request(forward(now_ns), std::move(request), out);
}

void HostProtocol::tell_utc(std::int64_t unix_ns, ProtocolOutput& out) {
  for (DeviceLink& link : links_) link.tell_utc(unix_ns, out);
}

void HostProtocol::set_sampling(std::int64_t now_ns, std::size_t device, bool on, ProtocolOutput& out) {
  if (device < links_.size()) links_[device].set_sampling(forward(now_ns), on, out);
}

void HostProtocol::set_power(std::int64_t now_ns, std::size_t device, PowerMode mode, ProtocolOutput& out) {
  if (device < links_.size()) links_[device].set_power(forward(now_ns), mode, out);
}

void HostProtocol::leave(std::int64_t now_ns, ProtocolOutput& out) {
  const std::int64_t now = forward(now_ns);
  for (DeviceLink& link : links_) link.leave(now, out);
}

bool HostProtocol::is_closed() const {
  return std::all_of(links_.begin(), links_.end(),
                     [](const DeviceLink& link) { return link.info().state == LinkState::closed; });
}

}  // namespace rigcal::livox
