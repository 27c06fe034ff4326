#pragma once

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <string>

namespace rigcal {

/// One connection to a server, of which the test decides what it sends and when.
class WebClient {
 public:
  explicit WebClient(std::uint16_t port, int flags = 0)
      : socket_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC | flags, 0)) {
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(port);
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    const timeval patience{0, 500'000};
    ::setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    static_cast<void>(::connect(socket_, reinterpret_cast<const sockaddr*>(&to), sizeof to));
  }
  ~WebClient() { ::close(socket_); }
  WebClient(const WebClient&) = delete;
  WebClient& operator=(const WebClient&) = delete;

  [[nodiscard]] bool send(const std::string& text) const {
    return ::send(socket_, text.data(), text.size(), MSG_NOSIGNAL) == static_cast<ssize_t>(text.size());
  }
  /// What comes until `last` is there, the server closes, or nothing comes for half a second.
  std::string read(const std::string& last = {}) {
    std::string text;
    std::array<char, 4096> part{};
    std::size_t looked_at = 0;
    while (last.empty() || text.find(last, looked_at) == std::string::npos) {
      looked_at = text.size() - std::min(text.size(), last.size());
      const ssize_t n = ::recv(socket_, part.data(), part.size(), 0);
      is_closed_ = n == 0 || (n < 0 && errno == ECONNRESET);
      if (n <= 0) break;
      text.append(part.data(), static_cast<std::size_t>(n));
    }
    return text;
  }
  [[nodiscard]] bool is_closed() const { return is_closed_; }

 private:
  int socket_;
  bool is_closed_ = false;
};

/// All that comes back for the head of a request.
inline std::string ask(std::uint16_t port, const std::string& head) {
  WebClient client(port);
  EXPECT_TRUE(client.send(head + "\r\n\r\n"));
  return client.read();
}

inline std::string get(std::uint16_t port, const std::string& path, const std::string& more = {}) {
  return ask(port, "GET " + path + " HTTP/1.1\r\nHost: localhost\r\nConnection: close" + more);
}

}  // namespace rigcal
