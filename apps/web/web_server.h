#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

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

/// One page with the state that it shows, over HTTP on one port, all addresses relative: GET / is the page, `state` the
/// state as JSON, `events` the same whenever it changes (server-sent events), `picture/<name>` a picture. Who comes
/// from elsewhere than loopback needs the token, as ?token= the first time, then as a cookie. Nothing can be changed
/// over it.
class WebServer {
 public:
  /// With an empty token nobody needs one. Errors (kind system): the address cannot be had.
  [[nodiscard]] static Expected<std::unique_ptr<WebServer>> start(const WebAddress& address, std::string token,
                                                                  std::string page);
  ~WebServer();
  WebServer(const WebServer&) = delete;
  WebServer& operator=(const WebServer&) = delete;

  /// From any thread; return at once.
  void publish(std::string state);
  void publish_picture(const std::string& name, std::string jpeg);
  /// With the port that it got where 0 was asked for.
  [[nodiscard]] std::uint16_t port() const;
  /// For the address line of a browser.
  [[nodiscard]] std::string url() const;

 private:
  class Serving;
  explicit WebServer(std::unique_ptr<Serving> serving);
  std::unique_ptr<Serving> serving_;
};

/// 128 random bits as text, from the system.
[[nodiscard]] Expected<std::string> make_token();

}  // namespace rigcal
