#include "core/base/utc_text.h"

#include <array>
#include <cstdio>
#include <ctime>

namespace rigcal {

std::string utc_text(std::int64_t unix_ns) {
  constexpr std::int64_t second = 1'000'000'000;
  std::int64_t part_ns = unix_ns % second;
  if (part_ns < 0) part_ns += second;
  const auto seconds = static_cast<std::time_t>((unix_ns - part_ns) / second);
  std::tm date{};
  gmtime_r(&seconds, &date);
  std::array<char, 32> day{};
  const std::size_t size = std::strftime(day.data(), day.size(), "%Y-%m-%d %H:%M:%S", &date);
  std::array<char, 8> part{};
  std::snprintf(part.data(), part.size(), ".%03d", static_cast<int>(part_ns / 1'000'000));
  return std::string(day.data(), size) + part.data();
}

}  // namespace rigcal
