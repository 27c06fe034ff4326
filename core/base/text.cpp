#include "core/base/text.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

namespace rigcal {
namespace {

bool is_tail(std::string_view text, std::size_t at) {
  return at < text.size() && (static_cast<unsigned char>(text[at]) & 0xC0U) == 0x80;
}

}  // namespace

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

std::size_t utf8_length(std::string_view text, std::size_t at) {
  const auto byte = [&](std::size_t k) { return static_cast<unsigned char>(text[k]); };
  const unsigned first = byte(at);
  if (first < 0x80) return 1;
  if (first >= 0xC2 && first <= 0xDF) return is_tail(text, at + 1) ? 2 : 0;
  if (first >= 0xE0 && first <= 0xEF) {
    if (!is_tail(text, at + 1) || !is_tail(text, at + 2)) return 0;
    const unsigned second = byte(at + 1);
    return (first == 0xE0 && second < 0xA0) || (first == 0xED && second > 0x9F) ? 0 : 3;
  }
  if (first >= 0xF0 && first <= 0xF4) {
    if (!is_tail(text, at + 1) || !is_tail(text, at + 2) || !is_tail(text, at + 3)) return 0;
    const unsigned second = byte(at + 1);
    return (first == 0xF0 && second < 0x90) || (first == 0xF4 && second > 0x8F) ? 0 : 4;
  }
  return 0;
}

std::string quoted_text(std::string_view text) {
  constexpr std::string_view digits = "0123456789abcdef";
  std::string quoted = "\"";
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t length = utf8_length(text, at);
    const char c = text[at];
    const auto code = static_cast<unsigned char>(c);
    if (length == 0) {
      quoted += utf8_replacement;
    } else if (c == '"' || c == '\\') {
      quoted += {'\\', c};
    } else if (code < 0x20 || code == 0x7F) {
      quoted += {'\\', 'x', digits[code >> 4], digits[code & 15]};
    } else {
      quoted += text.substr(at, length);
    }
    at += std::max<std::size_t>(length, 1);
  }
  return quoted + "\"";
}

std::string counted(std::uint64_t count, std::string_view noun) {
  return std::to_string(count).append(" ").append(noun).append(count == 1 ? "" : "s");
}

std::string joined(const std::vector<std::string>& parts, std::string_view separator) {
  std::string text;
  for (std::size_t i = 0; i < parts.size(); ++i) text.append(i == 0 ? "" : separator).append(parts[i]);
  return text;
}

std::string joined_some(const std::vector<std::string>& parts, std::size_t most) {
  if (parts.size() <= most) return joined(parts, ", ");
  const std::vector<std::string> some(parts.begin(), parts.begin() + static_cast<std::ptrdiff_t>(most));
  return joined(some, ", ") + " and " + std::to_string(parts.size() - most) + " more";
}

std::string small_letters(std::string_view text) {
  std::string small(text);
  for (char& c : small) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return small;
}

std::string key_text(std::string_view text) {
  // Words that a YAML 1.1 reader takes for a truth value or for nothing.
  constexpr std::array<std::string_view, 9> special{"y", "n", "yes", "no", "on", "off", "true", "false", "null"};
  const std::string lower = small_letters(text);
  bool plain = !text.empty();
  for (const char c : lower) {
    plain = plain && ((c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_');
  }
  plain = plain && !(lower[0] >= '0' && lower[0] <= '9');
  plain = plain && std::find(special.begin(), special.end(), lower) == special.end();
  return plain ? std::string(text) : quoted_text(text);
}

}  // namespace rigcal
