#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/base/error.h"

namespace rigcal::trigger {

/// A pulse a second (PPS) as the kernel saw its edge.
struct PpsPulse {
  std::uint32_t sequence = 0;  ///< Counts from 1, and starts again after 2^32.
  std::int64_t realtime_ns = 0;
};

/// The devices of this machine: "/dev/pps0".
[[nodiscard]] std::vector<std::string> list_pps();

/// The rising edges that a PPS device reports (RFC 2783).
class PpsDevice {
 public:
  /// `device`: "pps0" or "/dev/pps0". Errors (kind system) name it, the devices that there are, and the mend.
  [[nodiscard]] static Expected<PpsDevice> open(const std::string& device);
  ~PpsDevice();
  PpsDevice(PpsDevice&& other) noexcept;
  PpsDevice& operator=(PpsDevice&& other) noexcept;

  /// The next edge, for which it waits at most that long; nothing where none came. Errors: the device is gone.
  [[nodiscard]] Expected<std::optional<PpsPulse>> next(std::int64_t timeout_ns);

 private:
  PpsDevice(std::string device, int descriptor) : device_(std::move(device)), descriptor_(descriptor) {}
  std::string device_;
  int descriptor_ = -1;
};

}  // namespace rigcal::trigger
