#include "core/report/html_text.h"

#include "core/base/text.h"

namespace rigcal {

std::string html_text(std::string_view text) {
  std::string out;
  out.reserve(text.size());
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t length = utf8_length(text, at);
    const char c = text[at];
    const bool control = (static_cast<unsigned char>(c) < 0x20 && c != '\n' && c != '\t') || c == 0x7F;
    if (length == 0 || control) {
      out += utf8_replacement;
    } else if (c == '&') {
      out += "&amp;";
    } else if (c == '<') {
      out += "&lt;";
    } else if (c == '>') {
      out += "&gt;";
    } else if (c == '"') {
      out += "&quot;";
    } else if (c == '\'') {
      out += "&#39;";
    } else {
      out += text.substr(at, length);
    }
    at += length == 0 ? 1 : length;
  }
  return out;
}

std::string base64(ByteView bytes) {
  constexpr std::string_view digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  out.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t at = 0; at < bytes.size(); at += 3) {
    const std::size_t left = bytes.size() - at;
    const unsigned value = unsigned{bytes[at]} << 16U | (left > 1 ? unsigned{bytes[at + 1]} << 8U : 0U) |
                           (left > 2 ? unsigned{bytes[at + 2]} : 0U);
    out += digits[value >> 18U];
    out += digits[value >> 12U & 63U];
    out += left > 1 ? digits[value >> 6U & 63U] : '=';
    out += left > 2 ? digits[value & 63U] : '=';
  }
  return out;
}

}  // namespace rigcal
