#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/base/file_descriptor.h"
#include "drivers/trigger/pps_count.h"

namespace rigcal::trigger {

/// A pulse a second (PPS) as the kernel saw its edge.
struct PpsPulse {
  std::uint32_t sequence = 0;  ///< Counts from 1, and starts again after 2^32.
  std::uint32_t missed = 0;    ///< Before it, and since the last one that was seen.
  std::int64_t realtime_ns = 0;
};

/// The devices of this machine: "/dev/pps0".
[[nodiscard]] std::vector<std::string> list_pps();

/// The rising edges that a PPS device reports (RFC 2783).
class PpsDevice {
 public:
  /// `device`: "pps0" or "/dev/pps0". Errors (kind system) name it, the devices that there are, and the mend.
  [[nodiscard]] static Expected<PpsDevice> open(const std::string& device);

  /// The next edge, for which it waits at most that long; nothing where none came. Errors: the device is gone, also
  /// where another one is there by its name.
  [[nodiscard]] Expected<std::optional<PpsPulse>> next(std::int64_t timeout_ns);

 private:
  PpsDevice(std::string device, FileDescriptor file) : device_(std::move(device)), file_(std::move(file)) {}
  std::string device_;
  FileDescriptor file_;
  PpsCount count_{0};
};

/// Whether an open file is still the one of this name, which may have been removed, or made anew.
[[nodiscard]] bool is_still_there(int descriptor, const std::string& path);

}  // namespace rigcal::trigger
