#pragma once

#include <cstdint>
#include <vector>

#include "core/base/bytes.h"
#include "core/base/error.h"
#include "drivers/gige_codec/status.h"

/// The control channel of USB3 Vision (GenCP): memory is read and written by packets in little-endian order. Its status
/// codes are those of GigE Vision.
namespace rigcal::sim::usb3 {

inline constexpr std::size_t kControlHeaderBytes = 12;
inline constexpr std::size_t kMaxControlBytes = 1024;  ///< Of a command, and of an answer, with the header.

struct ControlCommand {
  enum class Kind : std::uint8_t { read, write, unknown };
  Kind kind = Kind::unknown;
  std::uint16_t number = 0;  ///< As it was sent.
  std::uint16_t id = 0;
  bool wants_answer = true;
  std::uint64_t address = 0;
  std::uint16_t count = 0;  ///< Bytes to read.
  ByteView bytes;           ///< To write; point into what was parsed.
};

/// Errors: too short, another key, a length that the packet does not have.
[[nodiscard]] Expected<ControlCommand> parse_control(ByteView packet);

[[nodiscard]] std::vector<std::uint8_t> encode_read_answer(std::uint16_t id, ByteView bytes);
[[nodiscard]] std::vector<std::uint8_t> encode_write_answer(std::uint16_t id, std::uint16_t written);
[[nodiscard]] std::vector<std::uint8_t> encode_refusal(const ControlCommand& command, gige::Status status);

// What a host sends.
[[nodiscard]] std::vector<std::uint8_t> encode_read(std::uint16_t id, std::uint64_t address, std::uint16_t count);
[[nodiscard]] std::vector<std::uint8_t> encode_write(std::uint16_t id, std::uint64_t address, ByteView bytes);

}  // namespace rigcal::sim::usb3
