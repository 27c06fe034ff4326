#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "core/base/error.h"

namespace rigcal::net {

using Ipv4 = std::array<std::uint8_t, 4>;  ///< Bytes in dotted order.

/// An IPv4 address of this machine. An interface with several addresses is several of these.
struct Interface {
  std::string name;
  int index = 0;  ///< The system's number, as it comes with datagrams.
  Ipv4 ip{};
  Ipv4 mask{};
  bool is_up = false;  ///< Switched on, with a carrier.
  bool is_loopback = false;
  int mtu = 0;
};

/// In the system's order. Errors: the system refuses.
[[nodiscard]] Expected<std::vector<Interface>> list_interfaces();

/// By the system's number; in words where there is none of it any more.
[[nodiscard]] std::string interface_name(int index);

/// Whether an address lies in the subnet of an interface.
[[nodiscard]] bool is_in_subnet(const Interface& interface, const Ipv4& ip);

/// 24 for 255.255.255.0.
[[nodiscard]] int prefix_length(const Ipv4& mask);

}  // namespace rigcal::net
