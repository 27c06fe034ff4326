#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "core/base/error.h"

namespace rigcal {

/// Where a page is served.
struct WebAddress {
  std::string host = "127.0.0.1";
  std::uint16_t port = 8340;

  /// Only this machine can reach it (and who comes through its ssh).
  [[nodiscard]] bool is_loopback() const;
};

/// "", "8080", "0.0.0.0:8080", "[::1]:8080": what is left out is as above. Errors: no address, no port.
[[nodiscard]] Expected<WebAddress> parse_web_address(std::string_view text);

/// Whether the Host of a request names this machine as only this machine does: localhost or an address of loopback,
/// with or without a port. A name of another site may lead here, too ("127.evil.example"), and must not.
[[nodiscard]] bool is_host_of_this_machine(std::string_view host);

/// The value of one cookie in a Cookie header; empty where it is not there.
[[nodiscard]] std::string_view cookie_value(std::string_view cookies, std::string_view name);

/// Whether two texts are the same, in a time that does not tell how much of them was.
[[nodiscard]] bool is_same_secret(std::string_view a, std::string_view b);

}  // namespace rigcal
