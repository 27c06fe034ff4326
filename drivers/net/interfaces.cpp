#include "drivers/net/interfaces.h"

#include <arpa/inet.h>
#include <ifaddrs.h>
#include <net/if.h>
#include <netinet/in.h>
#include <sys/ioctl.h>
#include <sys/socket.h>

#include <bit>
#include <cerrno>
#include <cstring>
#include <memory>

#include "core/base/file_descriptor.h"
#include "core/base/system_call.h"

namespace rigcal::net {
namespace {

Ipv4 address_of(const sockaddr& address) {
  sockaddr_in inet{};
  std::memcpy(&inet, &address, sizeof inet);
  Ipv4 ip{};
  std::memcpy(ip.data(), &inet.sin_addr, ip.size());
  return ip;
}

int mtu_of(const std::string& name) {
  const FileDescriptor any_socket(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  ifreq request{};
  name.copy(request.ifr_name, IFNAMSIZ - 1);
  return ioctl(any_socket.get(), SIOCGIFMTU, &request) != 0 ? 0 : request.ifr_mtu;
}

}  // namespace

Expected<std::vector<Interface>> list_interfaces() {
  ifaddrs* first = nullptr;
  if (getifaddrs(&first) != 0) return call_error("cannot list the network interfaces", errno);
  const std::unique_ptr<ifaddrs, decltype(&freeifaddrs)> list(first, &freeifaddrs);
  std::vector<Interface> interfaces;
  for (const ifaddrs* entry = first; entry != nullptr; entry = entry->ifa_next) {
    if (entry->ifa_addr == nullptr || entry->ifa_addr->sa_family != AF_INET) continue;
    Interface interface;
    interface.name = entry->ifa_name;
    interface.index = static_cast<int>(if_nametoindex(entry->ifa_name));
    interface.ip = address_of(*entry->ifa_addr);
    if (entry->ifa_netmask != nullptr) interface.mask = address_of(*entry->ifa_netmask);
    interface.is_up = (entry->ifa_flags & IFF_UP) != 0 && (entry->ifa_flags & IFF_RUNNING) != 0;
    interface.is_loopback = (entry->ifa_flags & IFF_LOOPBACK) != 0;
    interface.mtu = mtu_of(interface.name);
    interfaces.push_back(std::move(interface));
  }
  return interfaces;
}

std::string interface_name(int index) {
  std::array<char, IF_NAMESIZE> name{};
  if (if_indextoname(static_cast<unsigned>(index), name.data()) == nullptr) return "interface " + std::to_string(index);
  return name.data();
}

bool is_in_subnet(const Interface& interface, const Ipv4& ip) {
  for (std::size_t i = 0; i < ip.size(); ++i)
    if (((ip[i] ^ interface.ip[i]) & interface.mask[i]) != 0) return false;
  return true;
}

int prefix_length(const Ipv4& mask) {
  int bits = 0;
  for (const std::uint8_t byte : mask) bits += std::popcount(byte);
  return bits;
}

}  // namespace rigcal::net
