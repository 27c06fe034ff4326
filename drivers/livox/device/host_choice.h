#pragma once

#include <string>
#include <vector>

#include "core/base/error.h"
#include "drivers/livox/protocol/device_link.h"
#include "drivers/net/interfaces.h"
#include "drivers/net/udp_socket.h"

namespace rigcal::livox {

/// Which addresses of this machine listen for devices: those of the interface of that name, or the one that is asked
/// for. `auto`: all that are up, the loopback only where a wanted device has an address there; then those that have no
/// carrier yet, where a wanted device may come up behind them or nothing is up at all. Errors: there is no such
/// interface or address, or the one that is named is down; nothing is left.
[[nodiscard]] Expected<std::vector<net::Interface>> choose_hosts(const std::vector<net::Interface>& interfaces,
                                                                 const std::vector<WantedDevice>& devices,
                                                                 const std::string& interface,
                                                                 const std::string& host_ip);

/// The one of them that a datagram came in on, by the system's number of the interface and the subnet; where none has
/// that number, as after an adapter was plugged in anew, the one with the interface's address. An index out of range
/// where none fits.
[[nodiscard]] std::size_t host_of(const std::vector<net::Interface>& hosts, const net::Received& received);

}  // namespace rigcal::livox
