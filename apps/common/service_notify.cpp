#include "apps/common/service_notify.h"

#include <sys/socket.h>
#include <sys/un.h>

#include <cstddef>
#include <cstdlib>
#include <cstring>

namespace rigcal {

ServiceNotify::ServiceNotify() {
  const char* name = std::getenv("NOTIFY_SOCKET");
  if (name == nullptr || (name[0] != '/' && name[0] != '@') || std::strlen(name) >= sizeof(sockaddr_un::sun_path))
    return;
  address_ = name;
  ::unsetenv("NOTIFY_SOCKET");
  if (address_.front() == '@') address_.front() = '\0';
  socket_ = FileDescriptor(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
}

void ServiceNotify::alive(std::string_view status) {
  if (!is_watched()) return;
  std::string line(status);
  for (char& c : line) {
    if (c == '\n') c = ' ';  // A line is a message of its own.
  }
  send((is_ready_ ? "WATCHDOG=1\nSTATUS=" : "READY=1\nWATCHDOG=1\nSTATUS=") + line);
  is_ready_ = true;
}

void ServiceNotify::stopping() { send("STOPPING=1"); }

void ServiceNotify::send(std::string_view text) const {
  if (!is_watched()) return;
  sockaddr_un to{};
  to.sun_family = AF_UNIX;
  std::memcpy(to.sun_path, address_.data(), address_.size());
  const auto length = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + address_.size());
  static_cast<void>(
      ::sendto(socket_.get(), text.data(), text.size(), MSG_NOSIGNAL, reinterpret_cast<const sockaddr*>(&to), length));
}

}  // namespace rigcal
