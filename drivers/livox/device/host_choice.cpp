#include "drivers/livox/device/host_choice.h"

#include <algorithm>

#include "drivers/livox/protocol/host_protocol.h"

namespace rigcal::livox {
namespace {

std::string names_of(const std::vector<net::Interface>& interfaces) {
  std::string names;
  for (const net::Interface& interface : interfaces)
    names += (names.empty() ? "" : ", ") + interface.name + " " + rigcal::to_string(interface.ip) +
             (interface.is_up ? "" : " (down)");
  return names.empty() ? "none" : names;
}

// Whether a wanted device may be behind this interface rather than behind one of the others. Of a device without an
// address nobody knows.
bool may_be_needed(const net::Interface& interface, const std::vector<net::Interface>& others,
                   const std::vector<WantedDevice>& devices) {
  return std::any_of(devices.begin(), devices.end(), [&](const WantedDevice& device) {
    if (!device.ip) return true;
    return net::is_in_subnet(interface, *device.ip) &&
           std::none_of(others.begin(), others.end(),
                        [&device](const net::Interface& other) { return net::is_in_subnet(other, *device.ip); });
  });
}

}  // namespace

Expected<std::vector<net::Interface>> choose_hosts(const std::vector<net::Interface>& interfaces,
                                                   const std::vector<WantedDevice>& devices,
                                                   const std::string& interface, const std::string& host_ip) {
  const bool on_loopback = std::any_of(devices.begin(), devices.end(),
                                       [](const WantedDevice& device) { return device.ip && (*device.ip)[0] == 127; });
  std::vector<net::Interface> chosen;
  std::vector<net::Interface> without_carrier;
  for (const net::Interface& candidate : interfaces) {
    if (host_ip != "auto" && rigcal::to_string(candidate.ip) != host_ip) continue;
    if (interface != "auto" && candidate.name != interface) continue;
    const bool is_named = interface != "auto" || host_ip != "auto";
    if (!is_named && candidate.is_loopback != on_loopback) continue;
    if (!candidate.is_up && is_named)
      return system_error("the network interface is down or has no carrier", candidate.name,
                          "plug the cable in, or: sudo ip link set " + candidate.name + " up");
    (candidate.is_up ? chosen : without_carrier).push_back(candidate);
  }
  // A cable, a switch or a LiDAR may be switched on after this program, as where it is a service.
  std::erase_if(without_carrier, [&](const net::Interface& candidate) {
    return !chosen.empty() && !may_be_needed(candidate, chosen, devices);
  });
  chosen.insert(chosen.end(), without_carrier.begin(), without_carrier.end());
  if (chosen.size() > kMaxHosts) chosen.resize(kMaxHosts);
  if (!chosen.empty()) return chosen;
  const std::string wanted = "interface " + interface + ", address " + host_ip;
  return system_error("no network interface of this machine fits (there are: " + names_of(interfaces) + ")", wanted,
                      "give the interface of the LiDARs an address in their subnet, for example: sudo ip addr add "
                      "192.168.1.5/24 dev NAME");
}

std::size_t host_of(const std::vector<net::Interface>& hosts, const net::Received& received) {
  std::size_t fits = hosts.size();
  for (std::size_t i = 0; i < hosts.size(); ++i) {
    if (hosts[i].index != received.interface) continue;
    if (net::is_in_subnet(hosts[i], received.from.ip)) return i;
    if (fits == hosts.size()) fits = i;
  }
  if (fits < hosts.size()) return fits;
  const auto same_address = std::find_if(
      hosts.begin(), hosts.end(), [&received](const net::Interface& host) { return host.ip == received.local_ip; });
  return static_cast<std::size_t>(same_address - hosts.begin());
}

}  // namespace rigcal::livox
