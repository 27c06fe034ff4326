#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "core/base/error.h"
#include "core/base/file_descriptor.h"

namespace rigcal::turntable {

/// A serial port: 8 bits, no parity, 1 stop bit, raw. Also a pseudo-terminal.
class SerialPort {
 public:
  /// Errors (kind system): not there, no permission, taken by another program, no serial port, a speed it does not
  /// have.
  [[nodiscard]] static Expected<SerialPort> open(const std::string& path, int baud);

  /// What has come, waiting for it at most that long; empty where nothing came. Errors: the port is gone.
  [[nodiscard]] Expected<std::string> read(std::int64_t timeout_ns);
  /// Errors: the port is gone, or takes nothing for a second.
  Expected<void> write(std::string_view bytes);

 private:
  SerialPort(FileDescriptor file, std::string path) : file_(std::move(file)), path_(std::move(path)) {}
  FileDescriptor file_;
  std::string path_;
};

}  // namespace rigcal::turntable
