#include "core/base/utc_text.h"

#include <array>
#include <cstdio>
#include <ctime>

#include "core/base/seconds.h"

namespace rigcal {

std::string utc_text(std::int64_t unix_ns) {
  std::int64_t part_ns = unix_ns % ns_per_second;
  if (part_ns < 0) part_ns += ns_per_second;
  const auto seconds = static_cast<std::time_t>((unix_ns - part_ns) / ns_per_second);
  std::tm date{};
  gmtime_r(&seconds, &date);
  std::array<char, 32> day{};
  const std::size_t size = std::strftime(day.data(), day.size(), "%Y-%m-%d %H:%M:%S", &date);
  std::array<char, 8> part{};
  std::snprintf(part.data(), part.size(), ".%03d", static_cast<int>(part_ns / 1'000'000));
  return std::string(day.data(), size) + part.data();
}

}  // namespace rigcal
