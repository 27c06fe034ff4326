#pragma once

#include <cstdint>
#include <string>

#include "core/base/error.h"
#include "drivers/livox_codec/commands.h"

namespace rigcal::sim {

/// Something that happens to a virtual device while it serves.
struct Incident {
  enum class Kind : std::uint8_t { reboot, silence, status, owned_by_other, clock_jump, refusal };
  std::string sensor;
  double time_s = 0.0;  ///< After the devices were switched on.
  Kind kind = Kind::reboot;
  double length_s = 0.0;     ///< Of a silence, or of another host's possession; how far the clock jumps.
  std::uint32_t status = 0;  ///< The status word from then on; LiDARs have one.
  livox::Command refused = livox::Command::handshake;  ///< From then on.
};

/// "SENSOR,SECONDS,reboot", and with silence,SECONDS or taken,SECONDS or status,HEX or clock,SECONDS or refuse,COMMAND
/// in place of reboot. Errors name what is wrong.
[[nodiscard]] Expected<Incident> parse_incident(const std::string& text);

}  // namespace rigcal::sim
