#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/base/bytes.h"
#include "core/base/error.h"
#include "drivers/gige_codec/status.h"

namespace rigcal::gige {

/// A block on the stream is a leader (packet 0), payload packets (1 and on) and a trailer.
enum class PacketKind : std::uint8_t { leader = 1, trailer = 2, payload = 3 };

/// Of 32 bits, those that number a packet.
constexpr std::uint32_t kPacketIdBits = 0x00FF'FFFF;

/// A packet of the stream, block ids of 16 bits. `payload` points into the bytes that were parsed.
struct StreamPacket {
  Status status = Status::success;
  std::uint16_t block = 0;  ///< Counts from 1 and goes on with 1 after 65535; 0 is that of test packets.
  PacketKind kind = PacketKind::payload;
  std::uint32_t packet = 0;  ///< 24 bits.
  ByteView payload;
};

constexpr std::size_t kStreamHeaderBytes = 8;
/// A packet's size is told with the headers of IP and UDP.
constexpr std::size_t kWireHeaderBytes = 28;
/// What Ethernet adds to each packet on its wire: preamble, header, checksum and gap.
constexpr std::size_t kEthernetBytes = 38;

/// The packet in a datagram. Error: too short, 64 bit ids, a kind that is none of these.
[[nodiscard]] Expected<StreamPacket> parse_stream_packet(ByteView datagram);
/// The bytes before the payload.
[[nodiscard]] std::array<std::uint8_t, kStreamHeaderBytes> make_stream_header(const StreamPacket& packet);

/// What a block holds: the payload of its leader.
struct ImageLeader {
  static constexpr std::size_t kBytes = 36;

  bool has_chunks = false;      ///< The image is followed by chunks (and is one itself).
  std::uint64_t timestamp = 0;  ///< Ticks of the device.
  std::uint32_t pixel_format = 0;
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::uint32_t offset_x = 0;
  std::uint32_t offset_y = 0;
  std::uint16_t padding_x = 0;
  std::uint16_t padding_y = 0;
  bool operator==(const ImageLeader&) const = default;
};

/// Error: too short, or a block that is no image.
[[nodiscard]] Expected<ImageLeader> decode_leader(ByteView payload);
[[nodiscard]] std::vector<std::uint8_t> encode_leader(const ImageLeader& leader);

/// The payload of a block's last packet.
struct ImageTrailer {
  bool has_chunks = false;
  std::uint32_t height = 0;        ///< Rows that were really sent.
  std::uint32_t chunk_layout = 0;  ///< Another number where the chunks lie elsewhere than in the block before.
  bool operator==(const ImageTrailer&) const = default;
};

[[nodiscard]] Expected<ImageTrailer> decode_trailer(ByteView payload);
[[nodiscard]] std::vector<std::uint8_t> encode_trailer(const ImageTrailer& trailer);

/// The block id after this one.
[[nodiscard]] constexpr std::uint16_t next_block(std::uint16_t block) {
  return block == 0xFFFF ? std::uint16_t{1} : static_cast<std::uint16_t>(block + 1U);
}

}  // namespace rigcal::gige
