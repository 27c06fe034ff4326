#pragma once

#include <cstdint>
#include <variant>
#include <vector>

#include "drivers/gige_codec/bootstrap.h"
#include "drivers/gige_codec/command.h"
#include "drivers/gige_codec/status.h"

namespace rigcal::gige {

/// An ack without its framing. `payload` points into the bytes that were parsed.
struct AckFrame {
  Status status = Status::success;
  std::uint16_t ack = 0;  ///< The command's number plus one.
  std::uint16_t id = 0;   ///< Of the command.
  ByteView payload;
};

struct ForceIpAck {
  bool operator==(const ForceIpAck&) const = default;
};
struct ReadRegistersAck {
  std::vector<std::uint32_t> values;
  bool operator==(const ReadRegistersAck&) const = default;
};
struct WriteRegistersAck {
  std::uint16_t written = 0;  ///< How many; where one was refused, how many before it.
  bool operator==(const WriteRegistersAck&) const = default;
};
struct ReadMemoryAck {
  std::uint32_t address = 0;
  std::vector<std::uint8_t> bytes;
  bool operator==(const ReadMemoryAck&) const = default;
};
struct WriteMemoryAck {
  std::uint16_t written = 0;  ///< Bytes.
  bool operator==(const WriteMemoryAck&) const = default;
};
/// The command takes so much longer: wait.
struct PendingAck {
  std::uint16_t milliseconds = 0;
  bool operator==(const PendingAck&) const = default;
};

using Ack = std::variant<DeviceIdentity, ForceIpAck, ReadRegistersAck, WriteRegistersAck, ReadMemoryAck, WriteMemoryAck,
                         PendingAck>;

/// The ack in a datagram. Error: too short, a length that the datagram does not have.
[[nodiscard]] Expected<AckFrame> parse_ack(ByteView datagram);

/// Reads the payload of an ack that says success. Errors: an ack that is none of these, a payload of the wrong length.
[[nodiscard]] Expected<Ack> decode_ack(const AckFrame& frame);

/// The bytes of an ack of the command with that id.
[[nodiscard]] std::vector<std::uint8_t> encode_ack(const Ack& ack, std::uint16_t id, Status status = Status::success);

/// The ack without a payload that refuses any command.
[[nodiscard]] std::vector<std::uint8_t> make_refusal(const CommandFrame& frame, Status status);

}  // namespace rigcal::gige
