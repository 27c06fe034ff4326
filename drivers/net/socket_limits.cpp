#include "drivers/net/socket_limits.h"

#include <fstream>

namespace rigcal::net {

std::optional<std::size_t> largest_receive_buffer() {
  std::ifstream in("/proc/sys/net/core/rmem_max");
  std::size_t bytes = 0;
  if (in >> bytes) return bytes;
  return std::nullopt;
}

std::string receive_buffer_hint(std::size_t asked_bytes, std::size_t got_bytes) {
  return "the receive buffer has " + std::to_string(got_bytes / 1024) + " KiB instead of " +
         std::to_string(asked_bytes / 1024) + " KiB, so that packets can get lost when the machine is busy; " +
         "allow more with: sudo sysctl -w net.core.rmem_max=" + std::to_string(asked_bytes);
}

}  // namespace rigcal::net
