#pragma once

#include <string>
#include <vector>

#include "core/base/error.h"
#include "drivers/livox/protocol/device_link.h"
#include "drivers/net/interfaces.h"

namespace rigcal::livox {

/// Which addresses of this machine listen for devices: those of the interface of that name (`auto`: all that are up;
/// the loopback only where a wanted device has an address there), or the one that is asked for (`auto`: any). Errors:
/// there is no such interface or address, or it is down; nothing is left.
[[nodiscard]] Expected<std::vector<net::Interface>> choose_hosts(const std::vector<net::Interface>& interfaces,
                                                                 const std::vector<WantedDevice>& devices,
                                                                 const std::string& interface,
                                                                 const std::string& host_ip);

/// The one of them that a datagram from `from` came in on, by the system's number of the interface and the subnet; an
/// index out of range where none fits.
[[nodiscard]] std::size_t host_of(const std::vector<net::Interface>& hosts, int interface_index, const Ipv4& from);

}  // namespace rigcal::livox
