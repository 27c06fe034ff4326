#include "core/base/text.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

namespace rigcal {

std::string number_text(double value) {
  if (value == 0.0) return "0.0";
  if (std::isnan(value)) return ".nan";
  if (std::isinf(value)) return value > 0.0 ? ".inf" : "-.inf";
  std::array<char, 40> buffer{};
  const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value).ptr;
  std::string text(buffer.data(), end);
  if (text.find('.') == std::string::npos) text.insert(std::min(text.find('e'), text.size()), ".0");
  return text;
}

std::string fixed_text(double value, int digits) {
  // Enough for the largest double; to_chars knows no locale.
  std::array<char, 400> buffer{};
  const auto result = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value, std::chars_format::fixed,
                                    std::clamp(digits, 0, 17));
  std::string text(buffer.data(), result.ptr);
  if (text.front() == '-' && text.find_first_not_of("-0.") == std::string::npos) text.erase(0, 1);
  return text;
}

std::string quoted_text(std::string_view text) {
  constexpr std::string_view digits = "0123456789abcdef";
  std::string quoted = "\"";
  for (const char c : text) {
    const auto code = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') {
      quoted += {'\\', c};
    } else if (code < 0x20 || code == 0x7F) {
      quoted += {'\\', 'x', digits[code >> 4], digits[code & 15]};
    } else {
      quoted += c;
    }
  }
  return quoted + "\"";
}

std::string key_text(std::string_view text) {
  // Words that a YAML 1.1 reader takes for a truth value or for nothing.
  constexpr std::array<std::string_view, 9> special{"y", "n", "yes", "no", "on", "off", "true", "false", "null"};
  std::string lower(text);
  bool plain = !text.empty();
  for (char& c : lower) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    plain = plain && ((c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_');
  }
  plain = plain && !(lower[0] >= '0' && lower[0] <= '9');
  plain = plain && std::find(special.begin(), special.end(), lower) == special.end();
  return plain ? std::string(text) : quoted_text(text);
}

}  // namespace rigcal
