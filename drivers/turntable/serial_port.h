#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "core/base/error.h"

namespace rigcal::turntable {

/// A serial port: 8 bits, no parity, 1 stop bit, raw. Also a pseudo-terminal.
class SerialPort {
 public:
  /// Errors (kind system): not there, no permission, taken by another program, no serial port, a speed it does not
  /// have.
  [[nodiscard]] static Expected<SerialPort> open(const std::string& path, int baud);

  SerialPort(SerialPort&& other) noexcept;
  SerialPort& operator=(SerialPort&& other) noexcept;
  SerialPort(const SerialPort&) = delete;
  SerialPort& operator=(const SerialPort&) = delete;
  ~SerialPort();

  /// What has come, waiting for it at most that long; empty where nothing came. Errors: the port is gone.
  [[nodiscard]] Expected<std::string> read(std::int64_t timeout_ns);
  /// Errors: the port is gone, or takes nothing for a second.
  Expected<void> write(std::string_view bytes);

 private:
  SerialPort(int descriptor, std::string path) : descriptor_(descriptor), path_(std::move(path)) {}
  int descriptor_ = -1;
  std::string path_;
};

}  // namespace rigcal::turntable
