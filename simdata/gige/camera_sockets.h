#pragma once

#include <vector>

#include "core/base/error.h"
#include "drivers/gige_codec/command.h"
#include "drivers/net/udp_socket.h"

/// The sockets of virtual cameras; used by camera_server.cpp only.
namespace rigcal::sim {

/// Port 0: the system chooses. `shared`: several programs may listen there.
[[nodiscard]] Expected<net::UdpSocket> open_socket(const gige::Ipv4& ip, std::uint16_t port, bool shared = false);

/// Discoveries go to everybody, or to everybody in a network: sockets for all that may reach these cameras.
[[nodiscard]] Expected<std::vector<net::UdpSocket>> open_broadcasts(const std::vector<gige::Ipv4>& cameras);

/// Whether an address belongs into the network of the interface with this number: a broadcast comes in on an interface,
/// and a camera hangs on one.
[[nodiscard]] bool is_on_interface(const gige::Ipv4& ip, int number);

}  // namespace rigcal::sim
