#include "apps/web/web_server.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <list>
#include <thread>

#include "tests/apps/web/web_client.h"

namespace rigcal {
namespace {

using testing::HasSubstr;

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

TEST(WebServer, ItsPortServesAgainAtOnce) {
  auto server = serve({});
  const std::uint16_t port = server->port();
  EXPECT_THAT(get(port, "/"), HasSubstr(" 200 "));  // Leaves a connection in TIME_WAIT.
  server.reset();
  const auto again = WebServer::start({"127.0.0.1", port}, {}, "again");
  ASSERT_TRUE(again) << again.error().message();
  EXPECT_THAT(get(port, "/"), HasSubstr("again"));
}

TEST(WebServer, ServesNamesAndBothFamilies) {
  const auto named = WebServer::start({"localhost", 0}, {}, "");
  ASSERT_TRUE(named) << named.error().message();
  EXPECT_THAT((*named)->url(), HasSubstr("http://localhost:"));
  const auto both = WebServer::start({"::", 0}, {}, "the page");
  if (!both) GTEST_SKIP() << "no IPv6 here";
  EXPECT_THAT((*both)->url(), HasSubstr("http://[::]:"));
  EXPECT_THAT(get((*both)->port(), "/"), HasSubstr("the page"));
}

TEST(WebServer, GivesThePageOnceWhateverRangesAreAskedFor) {
  const auto server = serve({});
  std::string ranges = "\r\nRange: bytes=0-";
  for (int i = 0; i < 2600; ++i) ranges += ",0-";
  const std::string answer = get(server->port(), "/", ranges);
  EXPECT_THAT(answer, HasSubstr(" 200 "));
  EXPECT_LT(answer.size(), 1000U);
}

TEST(WebServer, TakesNoBody) {
  const auto server = serve({});
  for (const char* method : {"GET", "POST", "PUT", "DELETE"}) {
    for (const char* body : {"Content-Length: 100000000", "Transfer-Encoding: chunked"}) {
      WebClient client(server->port());
      ASSERT_TRUE(client.send(std::string(method) + " / HTTP/1.1\r\nHost: localhost\r\n" + body + "\r\n\r\n"));
      EXPECT_THAT(client.read(), HasSubstr(method == std::string("GET") ? " 200 " : " 405 "));
      EXPECT_TRUE(client.is_closed()) << method << " " << body;
    }
  }
}

TEST(WebServer, TellsItsWatchersTheNewsAndTakesNoMoreThanSix) {
  const auto server = serve({});
  std::list<WebClient> watchers;
  const std::string request = "GET /events HTTP/1.1\r\nHost: localhost\r\n\r\n";
  for (int i = 0; i < 6; ++i) {
    ASSERT_TRUE(watchers.emplace_back(server->port()).send(request));
    EXPECT_THAT(watchers.back().read("data: null\n\n"), HasSubstr("text/event-stream"));
  }
  EXPECT_THAT(get(server->port(), "/events"), HasSubstr(" 503 "));
  EXPECT_THAT(get(server->port(), "/"), HasSubstr(" 200 "));
  // Longer than any piece of it.
  const std::string news = std::string(100'000, 'x');
  server->publish(news);
  for (WebClient& watcher : watchers) {
    const std::string told = watcher.read("\n\n");
    EXPECT_EQ(std::ranges::count(told, 'x'), 100'000);
    EXPECT_THAT(told, HasSubstr("data: x"));
  }
  watchers.pop_front();
  std::string answer;
  for (int i = 0; i < 20 && answer.find(" 200 ") == std::string::npos; ++i) {
    server->publish("{}");
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    answer = get(server->port(), "/events");
  }
  EXPECT_THAT(answer, HasSubstr("data: {}\n\n"));
}

std::ptrdiff_t open_descriptors() {
  return std::distance(std::filesystem::directory_iterator("/proc/self/fd"), std::filesystem::directory_iterator());
}

TEST(WebServer, IdleConnectionsTakeFewDescriptorsAndThePageComesBack) {
  const auto server = serve({});
  const std::ptrdiff_t before = open_descriptors();
  {
    std::list<WebClient> idle;
    for (int i = 0; i < 200; ++i) idle.emplace_back(server->port(), SOCK_NONBLOCK);
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    EXPECT_LE(open_descriptors() - before, 200 + 12);
  }
  EXPECT_THAT(get(server->port(), "/"), HasSubstr("<p>the page</p>"));
}

// The most memory that this process ever had.
std::size_t peak_kib() {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    if (line.rfind("VmHWM:", 0) == 0) return std::stoul(line.substr(6));
  }
  return 0;
}

TEST(WebServer, ALineWithoutEndIsNotKept) {
  const auto server = serve({});
  const std::string part(1U << 16U, 'x');
  const std::size_t before = peak_kib();
  WebClient client(server->port());
  int sent = 0;
  while (sent < 320 && client.send(part)) ++sent;
  EXPECT_LT(sent, 320);  // 20 MB.
  EXPECT_LT(peak_kib() - before, 4096U);
  EXPECT_THAT(get(server->port(), "/"), HasSubstr(" 200 "));
}

TEST(WebServer, AHeadThatNeverEndsIsClosedHoweverItDribbles) {
  const auto server = serve({});
  WebClient client(server->port());
  ASSERT_TRUE(client.send("GET / HTTP/1.1\r\n"));
  const auto begin = std::chrono::steady_clock::now();
  while (!client.is_closed() && std::chrono::steady_clock::now() - begin < std::chrono::seconds(10)) {
    static_cast<void>(client.send("a"));
    static_cast<void>(client.read());
  }
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(7));
}

TEST(WebServer, EndsAtOnceWhoeverIsConnected) {
  auto server = serve({});
  server->publish(std::string(8'000'000, 'x'));  // More than goes out unread.
  std::list<WebClient> clients;
  for (const char* request :
       {"", "GET / HT", "GET / HTTP/1.1\r\nHost: localhost\r\n", "GET /state HTTP/1.1\r\nHost: localhost\r\n\r\n",
        "GET /events HTTP/1.1\r\nHost: localhost\r\n\r\n", "POST / HTTP/1.1\r\nContent-Length: 9\r\n\r\n"}) {
    ASSERT_TRUE(clients.emplace_back(server->port()).send(request));
  }
  auto& watcher = clients.emplace_back(server->port());
  ASSERT_TRUE(watcher.send("GET /events HTTP/1.1\r\nHost: localhost\r\n\r\n"));
  EXPECT_THAT(watcher.read("\n\n"), HasSubstr("data: "));  // From now on there is nothing to be told.
  const auto begin = std::chrono::steady_clock::now();
  server.reset();
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(1));
  watcher.read();
  EXPECT_TRUE(watcher.is_closed());
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
