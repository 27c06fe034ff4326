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

std::optional<std::size_t> stop_that_contains(std::span<const Stop> stops, std::int64_t start_ns, std::int64_t end_ns) {
  for (std::size_t j = 0; j < stops.size(); ++j) {
    if (start_ns >= stops[j].start_ns && end_ns <= stops[j].end_ns) return j;
  }
  return std::nullopt;
}

}  // namespace rigcal
