#include "simdata/gige/camera_sockets.h"

#include <algorithm>
#include <set>

#include "drivers/net/interfaces.h"

namespace rigcal::sim {

Expected<net::UdpSocket> open_socket(const gige::Ipv4& ip, std::uint16_t port, bool shared) {
  net::UdpOptions options;
  options.local = {ip, port};
  options.reuse_address = shared;
  return net::UdpSocket::open(options);
}

Expected<std::vector<net::UdpSocket>> open_broadcasts(const std::vector<gige::Ipv4>& cameras) {
  std::set<gige::Ipv4> addresses{{255, 255, 255, 255}};
  const auto interfaces = net::list_interfaces();
  if (!interfaces) return interfaces.error();
  for (const net::Interface& interface : *interfaces) {
    for (const gige::Ipv4& camera : cameras) {
      if (!net::is_in_subnet(interface, camera)) continue;
      gige::Ipv4 all = interface.ip;
      for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<std::uint8_t>(all[i] | ~interface.mask[i]);
      addresses.insert(all);
    }
  }
  std::vector<net::UdpSocket> sockets;
  for (const gige::Ipv4& address : addresses) {
    auto socket = open_socket(address, gige::kControlPort, true);
    if (!socket) return socket.error();
    sockets.push_back(*std::move(socket));
  }
  return sockets;
}

bool is_on_interface(const gige::Ipv4& ip, int number) {
  const auto interfaces = net::list_interfaces();
  return interfaces && std::any_of(interfaces->begin(), interfaces->end(), [&](const net::Interface& interface) {
           return interface.index == number && net::is_in_subnet(interface, ip);
         });
}

}  // namespace rigcal::sim
