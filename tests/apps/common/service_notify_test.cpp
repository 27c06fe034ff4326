#include "apps/common/service_notify.h"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <cstddef>
#include <cstdlib>
#include <cstring>

#include "tests/support/scratch_folder.h"

namespace rigcal {
namespace {

// The end of systemd.
class Manager {
 public:
  explicit Manager(const std::string& name) : socket_(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
    sockaddr_un at{};
    at.sun_family = AF_UNIX;
    std::memcpy(at.sun_path, name.data(), name.size());
    if (name.front() == '@') at.sun_path[0] = '\0';
    const auto length = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + name.size());
    EXPECT_EQ(::bind(socket_, reinterpret_cast<const sockaddr*>(&at), length), 0);
    ::setenv("NOTIFY_SOCKET", name.c_str(), 1);
  }
  ~Manager() { ::close(socket_); }
  Manager(const Manager&) = delete;
  Manager& operator=(const Manager&) = delete;

  std::string next() const {
    std::array<char, 512> text{};
    const ssize_t n = ::recv(socket_, text.data(), text.size(), MSG_DONTWAIT);
    return n < 0 ? "nothing" : std::string(text.data(), static_cast<std::size_t>(n));
  }

 private:
  int socket_;
};

TEST(ServiceNotify, SaysOnceThatItIsReadyAndThenThatItLives) {
  const auto folder = scratch_folder("service_notify");
  for (const std::string& name : {(folder / "notify").string(), "@rigcal_test_" + std::to_string(::getpid())}) {
    const Manager manager(name);
    ServiceNotify service;
    EXPECT_TRUE(service.is_watched());
    EXPECT_EQ(std::getenv("NOTIFY_SOCKET"), nullptr);
    EXPECT_EQ(manager.next(), "nothing");
    service.alive("settling, 0 stops");
    EXPECT_EQ(manager.next(), "READY=1\nWATCHDOG=1\nSTATUS=settling, 0 stops");
    service.alive("two\nlines");
    EXPECT_EQ(manager.next(), "WATCHDOG=1\nSTATUS=two lines");
    service.stopping();
    EXPECT_EQ(manager.next(), "STOPPING=1");
  }
}

TEST(ServiceNotify, TellsNothingWhereNobodyListens) {
  ::unsetenv("NOTIFY_SOCKET");
  ServiceNotify without;
  EXPECT_FALSE(without.is_watched());
  without.alive("x");
  for (const std::string& wrong : {std::string("relative"), "/" + std::string(200, 'x'), std::string()}) {
    ::setenv("NOTIFY_SOCKET", wrong.c_str(), 1);
    ServiceNotify service;
    EXPECT_FALSE(service.is_watched());
  }
  ::setenv("NOTIFY_SOCKET", "/nowhere/at/all", 1);
  ServiceNotify gone;
  gone.alive("x");
  gone.stopping();
}

}  // namespace
}  // namespace rigcal
