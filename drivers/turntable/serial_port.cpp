#include "drivers/turntable/serial_port.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <utility>

#include "core/base/system_call.h"

namespace rigcal::turntable {
namespace {

constexpr int write_wait_ms = 1000;

struct Speed {
  int baud;
  speed_t code;
};
constexpr std::array<Speed, 12> speeds{{{1200, B1200},
                                        {2400, B2400},
                                        {4800, B4800},
                                        {9600, B9600},
                                        {19200, B19200},
                                        {38400, B38400},
                                        {57600, B57600},
                                        {115200, B115200},
                                        {230400, B230400},
                                        {460800, B460800},
                                        {921600, B921600},
                                        {1000000, B1000000}}};

Error refused(const std::string& path, int code) {
  switch (code) {
    case ENOENT:
    case ENXIO:
    case ENODEV:
      return system_error("there is no such serial port", path,
                          "plug the turntable in, and see `ls /dev/ttyUSB* /dev/ttyACM*`");
    case EACCES:
    case EPERM:
      return system_error("no permission to use it", path, "add yourself to the group dialout and log in again");
    case EBUSY:
      return system_error("another program uses it", path, "end that program");
    default:
      return call_error("cannot be used", code, path);
  }
}

Error gone(const std::string& path) {
  return system_error("the turntable's serial port is gone", path, "plug it in again");
}

}  // namespace

Expected<SerialPort> SerialPort::open(const std::string& path, int baud) {
  const Speed* speed = nullptr;
  for (const Speed& each : speeds) {
    if (each.baud == baud) speed = &each;
  }
  if (speed == nullptr)
    return input_error("has no speed of " + std::to_string(baud) + " baud", path,
                       "use 9600, 115200 or another usual one");
  FileDescriptor file(::open(path.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC));
  if (!file.is_open()) return refused(path, errno);
  const int descriptor = file.get();
  SerialPort port(std::move(file), path);
  termios settings{};
  if (::tcgetattr(descriptor, &settings) != 0)
    return system_error("is no serial port", path, "check the port in the rig file");
  if (::ioctl(descriptor, TIOCEXCL) != 0 && errno == EBUSY) return refused(path, EBUSY);
  ::cfmakeraw(&settings);
  settings.c_cflag |= CLOCAL | CREAD;
  settings.c_cflag &= ~static_cast<tcflag_t>(CSTOPB | CRTSCTS);
  if (::cfsetspeed(&settings, speed->code) != 0 || ::tcsetattr(descriptor, TCSANOW, &settings) != 0)
    return refused(path, errno);
  ::tcflush(descriptor, TCIOFLUSH);
  return port;
}

Expected<std::string> SerialPort::read(std::int64_t timeout_ns) {
  pollfd wait{file_.get(), POLLIN, 0};
  const int ready = ::poll(&wait, 1, static_cast<int>(timeout_ns / 1'000'000));
  if (ready <= 0) return std::string();
  std::array<char, 512> bytes{};
  const ssize_t got = ::read(file_.get(), bytes.data(), bytes.size());
  if (got > 0) return std::string(bytes.data(), static_cast<std::size_t>(got));
  if (got < 0 && (errno == EAGAIN || errno == EINTR)) return std::string();
  return gone(path_);
}

Expected<void> SerialPort::write(std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t got = ::write(file_.get(), bytes.data(), bytes.size());
    if (got > 0) {
      bytes.remove_prefix(static_cast<std::size_t>(got));
      continue;
    }
    if (got < 0 && errno == EINTR) continue;
    if (got < 0 && errno != EAGAIN) return gone(path_);
    pollfd wait{file_.get(), POLLOUT, 0};
    if (::poll(&wait, 1, write_wait_ms) == 0)
      return system_error("the turntable takes no commands", path_, "check its cable and its power");
  }
  return {};
}

}  // namespace rigcal::turntable
