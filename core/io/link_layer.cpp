#include "core/io/link_layer.h"

#include <optional>

namespace rigcal {
namespace {

constexpr std::uint16_t ethertype_ipv4 = 0x0800;
constexpr std::size_t udp_header_bytes = 8;

std::uint16_t big_endian_16(ByteView bytes, std::size_t at) {
  return static_cast<std::uint16_t>((bytes[at] << 8) | bytes[at + 1]);
}

/// Strips an Ethernet-like type field at `at` and any VLAN tags after it (802.1Q, 802.1ad, and the old 0x9100).
/// An empty view: no IPv4.
std::optional<ByteView> after_ethertype(ByteView frame, std::size_t at) {
  while (at + 2 <= frame.size()) {
    const std::uint16_t type = big_endian_16(frame, at);
    if (type == 0x8100 || type == 0x88A8 || type == 0x9100) {
      at += 4;
      continue;
    }
    if (type != ethertype_ipv4) return ByteView{};
    return frame.subspan(at + 2);
  }
  return std::nullopt;
}

/// The IP packet of a frame; nothing where the frame is cut, an empty view where it holds something else.
std::optional<ByteView> ip_packet(LinkLayer link, ByteView frame) {
  switch (link) {
    case LinkLayer::ethernet:
      return after_ethertype(frame, 12);
    case LinkLayer::raw_ip:
      return frame;
    case LinkLayer::cooked_v1:
      return after_ethertype(frame, 14);
    case LinkLayer::cooked_v2: {
      if (frame.size() < 20) return std::nullopt;
      if (big_endian_16(frame, 0) != ethertype_ipv4) return ByteView{};
      return frame.subspan(20);
    }
    case LinkLayer::null: {
      // The address family AF_INET (2) in the byte order of the machine that recorded.
      if (frame.size() < 4) return std::nullopt;
      const bool little = frame[0] == 2 && frame[1] == 0 && frame[2] == 0 && frame[3] == 0;
      const bool big = frame[0] == 0 && frame[1] == 0 && frame[2] == 0 && frame[3] == 2;
      if (!little && !big) return ByteView{};
      return frame.subspan(4);
    }
  }
  return std::nullopt;
}

Endpoint endpoint(ByteView ip, std::size_t address_at, std::uint16_t port) {
  return {{ip[address_at], ip[address_at + 1], ip[address_at + 2], ip[address_at + 3]}, port};
}

}  // namespace

FrameKind parse_udp(LinkLayer link, ByteView frame, Datagram& datagram) {
  const std::optional<ByteView> packet = ip_packet(link, frame);
  if (!packet) return FrameKind::malformed;
  const ByteView ip = *packet;
  if (ip.empty()) return frame.empty() ? FrameKind::malformed : FrameKind::not_udp;
  if (ip[0] >> 4 != 4) return FrameKind::not_udp;
  // RFC 791, figure 4. The frame may be longer than the packet: Ethernet pads to 60 bytes.
  const std::size_t header_bytes = std::size_t{4} * (ip[0] & 0x0FU);
  if (header_bytes < 20 || ip.size() < header_bytes) return FrameKind::malformed;
  if (ip[9] != 17) return FrameKind::not_udp;
  if ((big_endian_16(ip, 6) & 0x3FFF) != 0) return FrameKind::fragment;  // more fragments, or an offset
  const std::size_t total_bytes = big_endian_16(ip, 2);
  if (total_bytes > ip.size() || total_bytes < header_bytes + udp_header_bytes) return FrameKind::malformed;
  const ByteView udp = ip.subspan(header_bytes, total_bytes - header_bytes);
  const std::size_t udp_bytes = big_endian_16(udp, 4);
  if (udp_bytes < udp_header_bytes || udp_bytes > udp.size()) return FrameKind::malformed;
  datagram.from = endpoint(ip, 12, big_endian_16(udp, 0));
  datagram.to = endpoint(ip, 16, big_endian_16(udp, 2));
  datagram.bytes = udp.subspan(udp_header_bytes, udp_bytes - udp_header_bytes);
  return FrameKind::udp;
}

}  // namespace rigcal
