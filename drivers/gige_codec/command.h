#pragma once

#include <array>
#include <cstdint>
#include <variant>
#include <vector>

#include "core/base/bytes.h"
#include "core/base/error.h"

/// GigE Vision as it goes over the network, bytes to structs and back: the control protocol (GVCP) and the stream
/// protocol (GVSP) of version 1.2 with 16 bit block ids. Nothing here knows a socket, a file or a clock; every function
/// may be called from any thread. All integers on the wire are in network order.
namespace rigcal::gige {

using Ipv4 = std::array<std::uint8_t, 4>;
using Mac = std::array<std::uint8_t, 6>;

constexpr std::uint16_t kControlPort = 3956;
constexpr std::size_t kHeaderBytes = 8;          ///< Of a control frame, command or ack.
constexpr std::size_t kMaxControlPayload = 540;  ///< 576 bytes with all headers pass every network in one piece.
constexpr std::size_t kMaxMemoryBytes = 536;     ///< Of one read or write of memory.

/// The commands; the ack of each is the next number.
enum class Command : std::uint16_t {
  discovery = 0x0002,
  force_ip = 0x0004,
  packet_resend = 0x0040,  ///< Answered on the stream.
  read_registers = 0x0080,
  write_registers = 0x0082,
  read_memory = 0x0084,
  write_memory = 0x0086,
  pending = 0x0088,  ///< Its ack alone is sent: the real one takes longer.
};

/// A command without its framing. `payload` points into the bytes that were parsed.
struct CommandFrame {
  bool wants_ack = true;
  bool extended_ids = false;  ///< Of a resend: 64 bit block ids.
  std::uint16_t command = 0;  ///< Any number.
  std::uint16_t id = 0;       ///< Repeated by the ack; never 0.
  ByteView payload;
};

struct DiscoveryRequest {
  bool operator==(const DiscoveryRequest&) const = default;
};
/// To the device of that hardware address, whatever its address is: take this one.
struct ForceIpRequest {
  Mac mac{};
  Ipv4 ip{};
  Ipv4 mask{};
  Ipv4 gateway{};
  bool operator==(const ForceIpRequest&) const = default;
};
/// Packets `first` .. `last` of a block once more.
struct ResendRequest {
  std::uint16_t channel = 0;
  std::uint16_t block = 0;
  std::uint32_t first = 0;
  std::uint32_t last = 0;
  bool operator==(const ResendRequest&) const = default;
};
struct ReadRegistersRequest {
  std::vector<std::uint32_t> addresses;  ///< 1 .. 135
  bool operator==(const ReadRegistersRequest&) const = default;
};
struct RegisterWrite {
  std::uint32_t address = 0;
  std::uint32_t value = 0;
  bool operator==(const RegisterWrite&) const = default;
};
struct WriteRegistersRequest {
  std::vector<RegisterWrite> writes;  ///< 1 .. 67
  bool operator==(const WriteRegistersRequest&) const = default;
};
struct ReadMemoryRequest {
  std::uint32_t address = 0;
  std::uint16_t count = 0;  ///< Bytes.
  bool operator==(const ReadMemoryRequest&) const = default;
};
struct WriteMemoryRequest {
  std::uint32_t address = 0;
  std::vector<std::uint8_t> bytes;
  bool operator==(const WriteMemoryRequest&) const = default;
};

using Request = std::variant<DiscoveryRequest, ForceIpRequest, ResendRequest, ReadRegistersRequest,
                             WriteRegistersRequest, ReadMemoryRequest, WriteMemoryRequest>;

/// The command in a datagram. Error: too short, another key byte, a length that the datagram does not have, an id of 0;
/// the error's `where` is the offset of the field.
[[nodiscard]] Expected<CommandFrame> parse_command(ByteView datagram);

/// Reads the payload of a command. Errors: a command that is none of these, a payload of the wrong length, more than
/// one frame may ask for, a resend with 64 bit ids or whose packets run backwards. Addresses and counts are not looked
/// at: the device answers for these with a status of its own.
[[nodiscard]] Expected<Request> decode_request(const CommandFrame& frame);

/// The bytes of a frame that asks for this; lists and memory must keep to the sizes given above.
[[nodiscard]] std::vector<std::uint8_t> encode_request(const Request& request, std::uint16_t id);

}  // namespace rigcal::gige
