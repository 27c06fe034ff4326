#include "core/records/records.h"

namespace rigcal {

std::string to_string(const std::array<std::uint8_t, 4>& ip) {
  std::string text;
  for (std::size_t i = 0; i < ip.size(); ++i) {
    if (i > 0) text += '.';
    text += std::to_string(ip[i]);
  }
  return text;
}

std::string to_string(const Endpoint& endpoint) { return to_string(endpoint.ip) + ":" + std::to_string(endpoint.port); }

}  // namespace rigcal
