#pragma once

#include <cstdint>
#include <cstdlib>
#include <string>
#include <vector>

namespace rigcal {

/// "aa01" to {0xAA, 0x01}; blanks are skipped.
inline std::vector<std::uint8_t> from_hex(const std::string& hex) {
  std::string digits;
  for (const char c : hex) {
    if (c != ' ') digits += c;
  }
  std::vector<std::uint8_t> bytes;
  for (std::size_t i = 0; i + 1 < digits.size(); i += 2) {
    bytes.push_back(static_cast<std::uint8_t>(std::strtoul(digits.substr(i, 2).c_str(), nullptr, 16)));
  }
  return bytes;
}

}  // namespace rigcal
