#pragma once

#include <cstdint>
#include <string>

namespace rigcal::sim {

/// Something that happens to a device while it serves.
struct Incident {
  enum class Kind : std::uint8_t { reboot, silence, status, owned_by_other };
  std::string sensor;
  double time_s = 0.0;  ///< After the devices were switched on.
  Kind kind = Kind::reboot;
  double length_s = 0.0;     ///< Of a silence, or of another host's possession.
  std::uint32_t status = 0;  ///< The status word from then on; LiDARs have one.
};

}  // namespace rigcal::sim
