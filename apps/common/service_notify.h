#pragma once

#include <string>
#include <string_view>

#include "core/base/file_descriptor.h"

namespace rigcal {

/// Tells the service manager (systemd) how the program does: datagrams to the socket that $NOTIFY_SOCKET names, a path
/// or, with an @, a name that is no file. Without it nothing is told. What cannot be told is not worth an error.
class ServiceNotify {
 public:
  /// From $NOTIFY_SOCKET, which programs that this one starts do not inherit then.
  ServiceNotify();

  [[nodiscard]] bool is_watched() const { return socket_.is_open(); }
  /// The program does what it is for, and `status` says what that is; also a sign of life for the watchdog.
  void alive(std::string_view status);
  /// It ends, which may take a while.
  void stopping();

 private:
  void send(std::string_view text) const;

  FileDescriptor socket_;
  std::string address_;
  bool is_ready_ = false;
};

}  // namespace rigcal
