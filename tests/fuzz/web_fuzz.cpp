// The page of a capture: the address that it is given, and what strangers send to it. The first byte says which.
#include <arpa/inet.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <string_view>

#include "apps/web/web_server.h"

namespace {

using namespace rigcal;

constexpr const char* token = "0123456789abcdef0123456789abcdef";
constexpr const char* secret = "what only those may see who have the token";

void require(bool condition) {
  if (!condition) std::abort();
}

bool is_ip(const std::string& host) {
  std::array<unsigned char, 16> bytes{};
  return ::inet_pton(AF_INET, host.c_str(), bytes.data()) == 1 ||
         ::inet_pton(AF_INET6, host.c_str(), bytes.data()) == 1;
}

void try_address(std::string_view text) {
  const auto address = parse_web_address(text);
  if (address) require(is_ip(address->host) || address->host == "localhost");
}

void try_host(std::string_view text) {
  if (!is_host_of_this_machine(text)) return;
  // What a browser takes for a name ends in letters or is all of these.
  const std::string name(
      text.substr(0, text.rfind(':') < text.size() && text.back() != ']' ? text.rfind(':') : text.size()));
  require(name == "localhost" || name == "[::1]" || (name.rfind("127.", 0) == 0 && is_ip(name)));
}

void try_cookie(std::string_view text) {
  const std::string_view value = cookie_value(text, "rigcal_token");
  require(value.find(';') == std::string_view::npos);
  require(value.empty() || text.find("rigcal_token=" + std::string(value)) != std::string_view::npos);
}

void try_request(std::string_view text) {
  static const std::unique_ptr<WebServer> server = [] {
    auto started = WebServer::start({"127.0.0.1", 0}, token, secret);
    require(started.has_value());
    (*started)->publish(secret);
    return *std::move(started);
  }();
  const int socket = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_port = htons(server->port());
  to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  const linger at_once{1, 0};  // No port is left waiting.
  ::setsockopt(socket, SOL_SOCKET, SO_LINGER, &at_once, sizeof at_once);
  const timeval patience{0, 200'000};  // A head that is still no whole one is waited for, and events have no end.
  ::setsockopt(socket, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
  require(::connect(socket, reinterpret_cast<const sockaddr*>(&to), sizeof to) == 0);
  const std::string whole = std::string(text) + "\r\n\r\n";
  static_cast<void>(::send(socket, whole.data(), whole.size(), MSG_NOSIGNAL));
  ::shutdown(socket, SHUT_WR);
  std::string answer;
  std::array<char, 4096> part{};
  for (ssize_t n = 0; answer.size() < 100'000 && (n = ::recv(socket, part.data(), part.size(), 0)) > 0;)
    answer.append(part.data(), static_cast<std::size_t>(n));
  ::close(socket);
  // By chance nobody sends 32 right digits, but a fuzzer that reads this program may.
  if (text.find(token) == std::string_view::npos) require(answer.find(secret) == std::string::npos);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0 || size > 4096) return 0;
  const std::string_view text(reinterpret_cast<const char*>(data) + 1, size - 1);
  switch (data[0] % 4) {
    case 0:
      try_address(text);
      break;
    case 1:
      try_host(text);
      break;
    case 2:
      try_cookie(text);
      break;
    default:
      try_request(text);
  }
  return 0;
}
