#include "apps/common/byte_size.h"

#include <utility>

#include "core/base/parse_number.h"

namespace rigcal {

std::optional<std::uint64_t> parse_bytes(const std::string& text) {
  std::string_view unit = text;
  const std::optional<double> value = take_number<double>(unit);
  if (!value || *value <= 0.0 || *value > 1e9) return std::nullopt;
  if (unit.starts_with(' ')) unit.remove_prefix(1);
  constexpr std::pair<const char*, double> units[] = {
      {"MB", 1e6}, {"GB", 1e9}, {"TB", 1e12}, {"MiB", 1048576.0}, {"GiB", 1073741824.0}};
  for (const auto& [name, bytes] : units) {
    const double size = *value * bytes;
    if (unit == name && size >= 1.0) return static_cast<std::uint64_t>(size);
  }
  return std::nullopt;
}

std::string check_bytes(const std::string& text) {
  return parse_bytes(text) ? std::string() : "write a size like 4GB or 500MB, not '" + text + "'";
}

}  // namespace rigcal
