#include "apps/web/web_server.h"

#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>

namespace rigcal {
namespace {

using testing::HasSubstr;

// What a server sends to one request before it is silent for half a second, or closes.
std::string ask(std::uint16_t port, const std::string& head) {
  const int socket = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_port = htons(port);
  to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  timeval patience{0, 500'000};
  ::setsockopt(socket, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
  std::string text;
  if (::connect(socket, reinterpret_cast<const sockaddr*>(&to), sizeof to) == 0) {
    const std::string request = head + "\r\n\r\n";
    EXPECT_EQ(::send(socket, request.data(), request.size(), MSG_NOSIGNAL), static_cast<ssize_t>(request.size()));
    std::array<char, 4096> part{};
    for (ssize_t n = 0; (n = ::recv(socket, part.data(), part.size(), 0)) > 0;) {
      text.append(part.data(), static_cast<std::size_t>(n));
    }
  }
  ::close(socket);
  return text;
}

std::string get(std::uint16_t port, const std::string& path, const std::string& more = {}) {
  return ask(port, "GET " + path + " HTTP/1.1\r\nHost: localhost\r\nConnection: close" + more);
}

std::unique_ptr<WebServer> serve(const std::string& token) {
  auto server = WebServer::start({"127.0.0.1", 0}, token, "<p>the page</p>");
  EXPECT_TRUE(server) << server.error().message();
  return *std::move(server);
}

TEST(WebServer, ServesPageStateEventsAndPictures) {
  const auto server = serve({});
  server->publish("{\"stops\":3}");
  server->publish_picture("left", "JPEG");
  EXPECT_THAT(get(server->port(), "/"), HasSubstr("<p>the page</p>"));
  EXPECT_THAT(get(server->port(), "/state"), HasSubstr("{\"stops\":3}"));
  EXPECT_THAT(get(server->port(), "/events"), HasSubstr("data: {\"stops\":3}\n\n"));
  EXPECT_THAT(get(server->port(), "/picture/left?7"), HasSubstr("JPEG"));
  EXPECT_THAT(get(server->port(), "/picture/right"), HasSubstr(" 404 "));
  EXPECT_THAT(get(server->port(), "/picture/../../etc/passwd"), HasSubstr(" 404 "));
  EXPECT_THAT(get(server->port(), "/elsewhere"), HasSubstr(" 404 "));
}

TEST(WebServer, ChangesNothingForAnybody) {
  const auto server = serve({});
  EXPECT_THAT(ask(server->port(), "POST /state HTTP/1.1\r\nHost: localhost\r\nContent-Length: 0\r\nConnection: close"),
              HasSubstr(" 405 "));
}

TEST(WebServer, IsNotReadByPagesOfOtherSites) {
  const auto server = serve({});
  EXPECT_THAT(ask(server->port(), "GET /state HTTP/1.1\r\nHost: evil.example\r\nConnection: close"),
              HasSubstr(" 403 "));
  EXPECT_THAT(ask(server->port(), "GET /state HTTP/1.1\r\nHost: 127.evil.example\r\nConnection: close"),
              HasSubstr(" 403 "));
}

TEST(WebServer, WantsItsTokenOnceAndThenTheCookie) {
  const auto server = serve("0123456789abcdef");
  EXPECT_THAT(server->url(), HasSubstr("?token=0123456789abcdef"));
  EXPECT_THAT(get(server->port(), "/"), HasSubstr(" 403 "));
  EXPECT_THAT(get(server->port(), "/?token=0123456789abcdee"), HasSubstr(" 403 "));
  const std::string answer = get(server->port(), "/?token=0123456789abcdef");
  EXPECT_THAT(answer, HasSubstr(" 200 "));
  EXPECT_THAT(answer, HasSubstr("Set-Cookie: rigcal_token=0123456789abcdef; HttpOnly"));
  EXPECT_THAT(get(server->port(), "/state", "\r\nCookie: a=b; rigcal_token=0123456789abcdef"), HasSubstr(" 200 "));
  EXPECT_THAT(get(server->port(), "/state", "\r\nCookie: rigcal_token=0123"), HasSubstr(" 403 "));
}

TEST(WebServer, SaysThatItsPortIsTaken) {
  const auto first = serve({});
  const auto second = WebServer::start({"127.0.0.1", first->port()}, {}, "");
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().kind, ErrorKind::system);
}

TEST(WebAddress, IsReadFromPortAddressOrBoth) {
  const auto told = [](const char* text) {
    const auto address = parse_web_address(text);
    return address ? address->host + " " + std::to_string(address->port) : "refused";
  };
  EXPECT_EQ(told(""), "127.0.0.1 8340");
  EXPECT_EQ(told("8080"), "127.0.0.1 8080");
  EXPECT_EQ(told("0.0.0.0:8080"), "0.0.0.0 8080");
  EXPECT_EQ(told("192.168.1.5"), "192.168.1.5 8340");
  EXPECT_EQ(told("[::1]:80"), "::1 80");
  EXPECT_EQ(told("[::1]"), "::1 8340");
  for (const char* wrong : {"elsewhere:80", "127.0.0.1:", "127.0.0.1:70000", "127.0.0.1:8x", "1.2.3:80", "-1"}) {
    EXPECT_EQ(told(wrong), "refused") << wrong;
  }
  EXPECT_TRUE(parse_web_address("8080")->is_loopback());
  EXPECT_FALSE(parse_web_address("0.0.0.0:8080")->is_loopback());
}

TEST(WebRequest, OnlyNamesOfLoopbackAreThisMachine) {
  for (const char* own :
       {"localhost", "localhost:8340", "127.0.0.1", "127.0.0.1:8340", "127.1.2.3:80", "[::1]", "[::1]:1"})
    EXPECT_TRUE(is_host_of_this_machine(own)) << own;
  for (const char* other : {"", "localhost.evil.example", "127.evil.example", "127.0.0.1.evil.example:8340",
                            "evil.example", "[::1].evil.example", "127.0.0.1:x", "localhost:", "128.0.0.1", "::1"})
    EXPECT_FALSE(is_host_of_this_machine(other)) << other;
}

TEST(WebRequest, ACookieIsFoundByItsWholeName) {
  EXPECT_EQ(cookie_value("a=b; rigcal_token=12=3; c=d", "rigcal_token"), "12=3");
  EXPECT_EQ(cookie_value("rigcal_token=", "rigcal_token"), "");
  EXPECT_EQ(cookie_value("xrigcal_token=12; rigcal_token2=3;;", "rigcal_token"), "");
}

TEST(WebServer, TokensAreLongAndNeverTheSame) {
  const auto token = make_token();
  ASSERT_TRUE(token);
  EXPECT_EQ(token->size(), 32U);
  EXPECT_NE(*token, *make_token());
}

}  // namespace
}  // namespace rigcal
