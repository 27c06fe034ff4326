#pragma once

#include <cstdint>

namespace rigcal::gige {

/// What a GigE Vision device says of a command or a packet. Values with the highest bit are errors.
enum class Status : std::uint16_t {
  success = 0x0000,
  packet_resent = 0x0100,
  not_implemented = 0x8001,
  invalid_parameter = 0x8002,
  invalid_address = 0x8003,
  write_protected = 0x8004,
  bad_alignment = 0x8005,
  access_denied = 0x8006,
  busy = 0x8007,
  packet_unavailable = 0x800C,
  data_overrun = 0x800D,
  invalid_header = 0x800E,
  packet_not_yet_available = 0x8010,
  packet_and_earlier_removed = 0x8011,
  packet_removed = 0x8012,
  error = 0x8FFF,
};

[[nodiscard]] constexpr bool is_error(Status status) { return (static_cast<unsigned>(status) & 0x8000U) != 0; }

/// In words, for example "access denied"; "unknown" for a value that is none of these.
[[nodiscard]] const char* to_string(Status status);

}  // namespace rigcal::gige
