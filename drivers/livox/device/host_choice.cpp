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

}  // namespace

Expected<std::vector<net::Interface>> choose_hosts(const std::vector<net::Interface>& interfaces,
                                                   const std::vector<WantedDevice>& devices,
                                                   const std::string& interface, const std::string& host_ip) {
  const bool on_loopback = std::any_of(devices.begin(), devices.end(),
                                       [](const WantedDevice& device) { return device.ip && (*device.ip)[0] == 127; });
  std::vector<net::Interface> chosen;
  for (const net::Interface& candidate : interfaces) {
    if (host_ip != "auto" && rigcal::to_string(candidate.ip) != host_ip) continue;
    if (interface != "auto" && candidate.name != interface) continue;
    const bool is_named = interface != "auto" || host_ip != "auto";
    if (!is_named && candidate.is_loopback != on_loopback) continue;
    if (!candidate.is_up) {
      if (!is_named) continue;
      return system_error("the network interface is down or has no carrier", candidate.name,
                          "plug the cable in, or: sudo ip link set " + candidate.name + " up");
    }
    if (chosen.size() < kMaxHosts) chosen.push_back(candidate);
  }
  if (!chosen.empty()) return chosen;
  const std::string wanted = "interface " + interface + ", address " + host_ip;
  return system_error("no network interface of this machine fits (there are: " + names_of(interfaces) + ")", wanted,
                      "give the interface of the LiDARs an address in their subnet, for example: sudo ip addr add "
                      "192.168.1.5/24 dev NAME");
}

std::size_t host_of(const std::vector<net::Interface>& hosts, int interface_index, const Ipv4& from) {
  std::size_t fits = hosts.size();
  for (std::size_t i = 0; i < hosts.size(); ++i) {
    if (hosts[i].index != interface_index) continue;
    if (net::is_in_subnet(hosts[i], from)) return i;
    if (fits == hosts.size()) fits = i;
  }
  return fits;
}

}  // namespace rigcal::livox
