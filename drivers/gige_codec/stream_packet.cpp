#include "drivers/gige_codec/stream_packet.h"

#include <optional>
#include <string>

#include "core/base/network_order.h"

namespace rigcal::gige {
namespace {

constexpr std::uint8_t extended_ids = 0x80;
constexpr std::uint8_t kind_bits = 0x0F;
constexpr std::uint16_t image_type = 0x0001;
constexpr std::uint16_t chunk_bit = 0x4000;

Error wrong(const std::string& what, const char* where) { return input_error(what, where); }

// The type of a block's payload, as leader and trailer say it; nothing where it is no image.
std::optional<bool> read_has_chunks(ByteReader& reader) {
  static_cast<void>(reader.take(2));
  const auto type = read_network<std::uint16_t>(reader);
  if ((type & ~chunk_bit) != image_type) return std::nullopt;
  return (type & chunk_bit) != 0;
}

void write_type(ByteWriter& writer, bool has_chunks) {
  write_network(writer, std::uint16_t{0});
  write_network(writer, static_cast<std::uint16_t>(image_type | (has_chunks ? chunk_bit : 0U)));
}

}  // namespace

Expected<StreamPacket> parse_stream_packet(ByteView datagram) {
  constexpr const char* where = "a GigE Vision stream packet";
  ByteReader reader(datagram);
  StreamPacket packet;
  packet.status = static_cast<Status>(read_network<std::uint16_t>(reader));
  packet.block = read_network<std::uint16_t>(reader);
  const auto format = read_network<std::uint32_t>(reader);
  if (!reader.ok()) return wrong("it is shorter than a header", where);
  const auto kind = static_cast<std::uint8_t>(format >> 24U);
  if ((kind & extended_ids) != 0) return wrong("block ids of 64 bits are not spoken here", where);
  if ((kind & kind_bits) < 1 || (kind & kind_bits) > 3)
    return wrong("a packet of the kind " + std::to_string(kind & kind_bits) + " is not known", where);
  packet.kind = static_cast<PacketKind>(kind & kind_bits);
  packet.packet = format & kPacketIdBits;
  packet.payload = reader.take(reader.left());
  return packet;
}

std::array<std::uint8_t, kStreamHeaderBytes> make_stream_header(const StreamPacket& packet) {
  const auto status = static_cast<unsigned>(packet.status);
  const auto byte = [](std::uint32_t value, unsigned shift) { return static_cast<std::uint8_t>(value >> shift); };
  return {byte(status, 8),
          byte(status, 0),
          byte(packet.block, 8),
          byte(packet.block, 0),
          static_cast<std::uint8_t>(packet.kind),
          byte(packet.packet, 16),
          byte(packet.packet, 8),
          byte(packet.packet, 0)};
}

Expected<ImageLeader> decode_leader(ByteView payload) {
  constexpr const char* where = "the leader of a GigE Vision block";
  ByteReader reader(payload);
  ImageLeader leader;
  const std::optional<bool> has_chunks = read_has_chunks(reader);
  if (!reader.ok()) return wrong("it ends too soon", where);
  if (!has_chunks) return wrong("the block holds no image", where);
  leader.has_chunks = *has_chunks;
  leader.timestamp = read_network<std::uint64_t>(reader);
  leader.pixel_format = read_network<std::uint32_t>(reader);
  leader.width = read_network<std::uint32_t>(reader);
  leader.height = read_network<std::uint32_t>(reader);
  leader.offset_x = read_network<std::uint32_t>(reader);
  leader.offset_y = read_network<std::uint32_t>(reader);
  leader.padding_x = read_network<std::uint16_t>(reader);
  leader.padding_y = read_network<std::uint16_t>(reader);
  if (!reader.ok()) return wrong("it ends too soon", where);
  return leader;
}

std::vector<std::uint8_t> encode_leader(const ImageLeader& leader) {
  std::vector<std::uint8_t> out;
  ByteWriter writer(out);
  write_type(writer, leader.has_chunks);
  write_network(writer, leader.timestamp);
  for (const std::uint32_t value : {leader.pixel_format, leader.width, leader.height, leader.offset_x, leader.offset_y})
    write_network(writer, value);
  write_network(writer, leader.padding_x);
  write_network(writer, leader.padding_y);
  return out;
}

Expected<ImageTrailer> decode_trailer(ByteView payload) {
  constexpr const char* where = "the trailer of a GigE Vision block";
  ByteReader reader(payload);
  ImageTrailer trailer;
  const std::optional<bool> has_chunks = read_has_chunks(reader);
  if (reader.ok() && !has_chunks) return wrong("the block holds no image", where);
  trailer.height = read_network<std::uint32_t>(reader);
  if (has_chunks.value_or(false)) {
    trailer.has_chunks = true;
    trailer.chunk_layout = read_network<std::uint32_t>(reader);
  }
  if (!reader.ok()) return wrong("it ends too soon", where);
  return trailer;
}

std::vector<std::uint8_t> encode_trailer(const ImageTrailer& trailer) {
  std::vector<std::uint8_t> out;
  ByteWriter writer(out);
  write_type(writer, trailer.has_chunks);
  write_network(writer, trailer.height);
  if (trailer.has_chunks) write_network(writer, trailer.chunk_layout);
  return out;
}

}  // namespace rigcal::gige
