#include "apps/web/web_request.h"

#include <arpa/inet.h>

#include <array>

#include "core/base/parse_number.h"

namespace rigcal {
namespace {

bool is_address_of(int family, const std::string& text) {
  std::array<unsigned char, 16> bytes{};
  return ::inet_pton(family, text.c_str(), bytes.data()) == 1;
}

bool is_address(const std::string& text) { return is_address_of(AF_INET, text) || is_address_of(AF_INET6, text); }

}  // namespace

bool WebAddress::is_loopback() const { return host == "::1" || host == "localhost" || host.rfind("127.", 0) == 0; }

Expected<WebAddress> parse_web_address(std::string_view text) {
  WebAddress address;
  std::string_view port = text;
  const std::size_t colon = text.rfind(':');
  if (colon != std::string_view::npos && text.back() != ']') {
    address.host = std::string(text.substr(0, colon));
    port = text.substr(colon + 1);
  } else if (text.find('.') != std::string_view::npos || (!text.empty() && text.front() == '[')) {
    address.host = std::string(text);
    port = {};
  }
  if (address.host.size() > 2 && address.host.front() == '[' && address.host.back() == ']') {
    address.host = address.host.substr(1, address.host.size() - 2);
  }
  // "127.0.0.1:" lacks its port, "[::1]" does not.
  const bool has_port = !port.empty() || (!text.empty() && text.back() == ':');
  const bool is_host = is_address(address.host) || address.host == "localhost";
  const auto number = parse_number<std::uint16_t>(port);
  // A text that ends in the middle for the system is no address.
  if (text.find('\0') != std::string_view::npos || !is_host || (has_port && !number)) {
    return input_error("'" + std::string(text) + "' is no address and port", {},
                       "write ADDR:PORT, like 127.0.0.1:8340");
  }
  if (has_port) address.port = *number;
  return address;
}

bool is_host_of_this_machine(std::string_view host) {
  if (host.find('\0') != std::string_view::npos) return false;
  std::string_view name = host;
  const std::size_t bracket = host.rfind(']');
  const std::size_t colon = host.rfind(':');
  if (colon != std::string_view::npos && (bracket == std::string_view::npos || colon > bracket)) {
    if (!parse_number<std::uint16_t>(host.substr(colon + 1))) return false;
    name = host.substr(0, colon);
  }
  if (name == "localhost" || name == "[::1]") return true;
  return name.substr(0, 4) == "127." && is_address_of(AF_INET, std::string(name));
}

std::string_view cookie_value(std::string_view cookies, std::string_view name) {
  while (!cookies.empty()) {
    const std::size_t end = cookies.find(';');
    std::string_view cookie = cookies.substr(0, end);
    cookies = end == std::string_view::npos ? std::string_view() : cookies.substr(end + 1);
    while (!cookie.empty() && cookie.front() == ' ') cookie.remove_prefix(1);
    const std::size_t equals = cookie.find('=');
    if (equals != std::string_view::npos && cookie.substr(0, equals) == name) return cookie.substr(equals + 1);
  }
  return {};
}

bool is_same_secret(std::string_view a, std::string_view b) {
  if (a.size() != b.size()) return false;
  unsigned difference = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    difference |= static_cast<unsigned>(static_cast<unsigned char>(a[i]) ^ static_cast<unsigned char>(b[i]));
  }
  return difference == 0;
}

}  // namespace rigcal
