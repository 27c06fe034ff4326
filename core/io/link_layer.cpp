#include "core/io/link_layer.h"

namespace rigcal {
namespace {

constexpr std::uint16_t ethertype_ipv4 = 0x0800;
constexpr std::uint16_t ethertype_ipv6 = 0x86DD;

/// What follows the header of the link layer.
struct Payload {
  FrameKind kind = FrameKind::malformed;  ///< `udp_part` stands for any IPv4 here.
  ByteView ip;
};

std::uint16_t big_endian_16(ByteView bytes, std::size_t at) {
  return static_cast<std::uint16_t>((bytes[at] << 8) | bytes[at + 1]);
}

Payload of_ethertype(std::uint16_t type, ByteView rest) {
  if (type == ethertype_ipv4) return {FrameKind::udp_part, rest};
  return {type == ethertype_ipv6 ? FrameKind::ipv6 : FrameKind::not_udp, {}};
}

/// Strips an Ethernet-like type field at `at` and any VLAN tags after it (802.1Q, 802.1ad, and the old 0x9100).
Payload after_ethertype(ByteView frame, std::size_t at) {
  while (at + 2 <= frame.size()) {
    const std::uint16_t type = big_endian_16(frame, at);
    if (type != 0x8100 && type != 0x88A8 && type != 0x9100) return of_ethertype(type, frame.subspan(at + 2));
    at += 4;
  }
  return {};
}

/// The address family in the byte order of the machine that recorded: AF_INET is 2 everywhere, AF_INET6 is not.
Payload after_family(ByteView frame) {
  if (frame.size() < 4) return {};
  const std::uint32_t big = (std::uint32_t{big_endian_16(frame, 0)} << 16U) | big_endian_16(frame, 2);
  const std::uint32_t family = frame[0] == 0 ? big : __builtin_bswap32(big);
  if (family == 2) return {FrameKind::udp_part, frame.subspan(4)};
  const bool ipv6 = family == 10 || family == 24 || family == 28 || family == 30;
  return {ipv6 ? FrameKind::ipv6 : FrameKind::not_udp, {}};
}

Payload after_link_layer(LinkLayer link, ByteView frame) {
  switch (link) {
    case LinkLayer::ethernet:
      return after_ethertype(frame, 12);
    case LinkLayer::raw_ip:
      return {FrameKind::udp_part, frame};
    case LinkLayer::cooked_v1:
      return after_ethertype(frame, 14);
    case LinkLayer::cooked_v2:
      // The type stands in front here; tags of a VLAN still come right before the packet.
      if (frame.size() < 20) return {};
      if (big_endian_16(frame, 0) == 0x8100 || big_endian_16(frame, 0) == 0x88A8) return after_ethertype(frame, 22);
      return of_ethertype(big_endian_16(frame, 0), frame.subspan(20));
    case LinkLayer::null:
      return after_family(frame);
  }
  return {};
}

}  // namespace

std::optional<LinkLayer> link_layer_of(std::uint32_t link_type) {
  switch (link_type) {
    case 1:
      return LinkLayer::ethernet;
    case 12:  // what systems where it is DLT_RAW have written
    case 14:
    case 101:
    case 228:
    case 229:  // IPv6 only: read to be counted
      return LinkLayer::raw_ip;
    case 113:
      return LinkLayer::cooked_v1;
    case 276:
      return LinkLayer::cooked_v2;
    case 0:
    case 108:
      return LinkLayer::null;
    default:
      return std::nullopt;
  }
}

FrameKind find_udp(LinkLayer link, ByteView frame, IpPart& part) {
  const Payload payload = after_link_layer(link, frame);
  if (payload.kind != FrameKind::udp_part) return payload.kind;
  const ByteView ip = payload.ip;
  if (ip.empty()) return FrameKind::malformed;
  if (ip[0] >> 4 == 6) return FrameKind::ipv6;
  if (ip[0] >> 4 != 4) return FrameKind::not_udp;
  // RFC 791, figure 4. The frame may be longer than the packet: Ethernet pads to 60 bytes.
  const std::size_t header_bytes = std::size_t{4} * (ip[0] & 0x0FU);
  if (header_bytes < 20 || ip.size() < header_bytes) return FrameKind::malformed;
  if (ip[9] != 17) return FrameKind::not_udp;
  std::size_t total_bytes = big_endian_16(ip, 2);
  if (total_bytes == 0) total_bytes = ip.size();  // left to the network card, as the checksums
  if (total_bytes > ip.size() || total_bytes < header_bytes) return FrameKind::malformed;
  for (std::size_t i = 0; i < 4; ++i) {
    part.from[i] = ip[12 + i];
    part.to[i] = ip[16 + i];
  }
  const std::uint16_t fragment = big_endian_16(ip, 6);
  part.id = big_endian_16(ip, 4);
  part.offset = std::size_t{8} * (fragment & 0x1FFFU);
  part.more_to_come = (fragment & 0x2000U) != 0;
  part.data = ip.subspan(header_bytes, total_bytes - header_bytes);
  return FrameKind::udp_part;
}

bool parse_udp(const IpPart& part, Datagram& datagram) {
  const ByteView udp = part.data;
  if (udp.size() < udp_header_bytes) return false;
  const std::size_t udp_bytes = big_endian_16(udp, 4);
  if (udp_bytes < udp_header_bytes || udp_bytes > udp.size()) return false;
  datagram.from = {part.from, big_endian_16(udp, 0)};
  datagram.to = {part.to, big_endian_16(udp, 2)};
  datagram.bytes = udp.subspan(udp_header_bytes, udp_bytes - udp_header_bytes);
  return true;
}

}  // namespace rigcal
