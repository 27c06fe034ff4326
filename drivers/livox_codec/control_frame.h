#pragma once

#include <cstdint>
#include <vector>

#include "core/base/bytes.h"
#include "core/base/error.h"

/// The Livox network protocol of the SDK v1 generation (Mid-40, Mid-70, Mid-100, Horizon, Tele-15, Avia, Hub): bytes to
/// structs and back. Nothing here knows a socket, a file or a clock; every function may be called from any thread.
namespace rigcal::livox {

/// The checksum of a frame's first seven bytes: CCITT polynomial, reflected, started with the letters "LI".
[[nodiscard]] std::uint16_t crc16(ByteView bytes);
/// The checksum of a whole frame: the usual CRC-32, started with the letters "VOX" and a line feed.
[[nodiscard]] std::uint32_t crc32(ByteView bytes);

enum class FrameType : std::uint8_t {
  command = 0,  ///< Wants an ack. The vendor's own software sends its handshake as `ack`, though: accept both.
  ack = 1,      ///< Repeats the `seq` of what it answers.
  message = 2,  ///< Wants no ack.
};

enum class CommandSet : std::uint8_t { general = 0, lidar = 1, hub = 2 };

/// A control frame without its framing. `payload` points into the bytes that were parsed.
struct ControlFrame {
  FrameType type = FrameType::command;
  std::uint16_t seq = 0;
  CommandSet set = CommandSet::general;
  std::uint8_t id = 0;
  ByteView payload;
};

constexpr std::size_t kMinFrameBytes = 15;
constexpr std::size_t kMaxFrameBytes = 1400;

/// The frame at the start of a datagram. Error: start byte, version, length, type, set or a checksum is wrong; the
/// error's `where` is the offset of the field.
[[nodiscard]] Expected<ControlFrame> parse_control_frame(ByteView datagram);

/// The bytes of a frame, checksums included. The payload must leave the frame within `kMaxFrameBytes`.
[[nodiscard]] std::vector<std::uint8_t> make_control_frame(const ControlFrame& frame);

}  // namespace rigcal::livox
