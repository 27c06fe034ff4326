#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "apps/web/web_request.h"

namespace rigcal {

/// One page with the state that it shows, over HTTP on one port, all addresses relative: GET / is the page, `state` the
/// state as JSON, `events` the same whenever it changes (server-sent events), `picture/<name>` a picture. Who comes
/// from elsewhere than loopback needs the token, as ?token= the first time, then as a cookie. Nothing can be changed
/// over it. Whoever connects and whatever is sent, it takes a dozen descriptors and little memory, and its end well
/// under a second.
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
