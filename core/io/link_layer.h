#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "core/records/records.h"

namespace rigcal {

/// RFC 768.
inline constexpr std::size_t udp_header_bytes = 8;

/// What stands before the IP header in the frames of a dump.
enum class LinkLayer { ethernet, raw_ip, cooked_v1, cooked_v2, null };

/// By the LINKTYPE_ number of a capture file; nothing for what is not read.
[[nodiscard]] std::optional<LinkLayer> link_layer_of(std::uint32_t link_type);

/// What an IPv4 packet that carries UDP holds: a whole datagram with its header, or a piece of one.
struct IpPart {
  std::array<std::uint8_t, 4> from{};
  std::array<std::uint8_t, 4> to{};
  std::uint16_t id = 0;       ///< The same in all pieces of one packet.
  std::size_t offset = 0;     ///< Of `data` in the whole, bytes.
  bool more_to_come = false;  ///< Not the last piece.
  ByteView data;              ///< Lives as long as the frame.

  [[nodiscard]] bool is_fragment() const { return offset > 0 || more_to_come; }
};

enum class FrameKind { udp_part, ipv6, not_udp, malformed };

/// Finds the IPv4 packet in one captured frame; fills in `part` where it carries UDP. Checksums are not looked at:
/// capturing machines often leave them to the network card.
[[nodiscard]] FrameKind find_udp(LinkLayer link, ByteView frame, IpPart& part);

/// Takes a whole UDP packet apart: fills in from, to and bytes (a view into `part.data`), not the stamp. False where
/// its header contradicts its length.
[[nodiscard]] bool parse_udp(const IpPart& part, Datagram& datagram);

}  // namespace rigcal
