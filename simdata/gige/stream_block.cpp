#include "simdata/gige/stream_block.h"

#include <algorithm>
#include <bit>
#include <utility>

#include "core/base/network_order.h"
#include "drivers/gige_codec/chunks.h"

namespace rigcal::sim {
namespace {

void append_chunks(const FrameOrder& order, std::vector<std::uint8_t>& payload) {
  gige::close_chunk(payload, kImageChunk, order.settings.image_bytes);
  const auto append = [&](ChunkKind kind, std::uint64_t value) {
    if (!order.settings.chunks[static_cast<std::size_t>(kind)]) return;
    ByteWriter writer(payload);
    write_network(writer, value);
    gige::close_chunk(payload, chunk_id(kind), sizeof value);
  };
  append(ChunkKind::frame_id, order.number);
  append(ChunkKind::timestamp, order.ticks);
  append(ChunkKind::exposure_time, std::bit_cast<std::uint64_t>(order.settings.exposure_us));
  append(ChunkKind::gain, std::bit_cast<std::uint64_t>(order.settings.gain_db));
}

// Which chunks there are tells where they lie.
std::uint32_t layout_of(const CameraSettings& settings) {
  std::uint32_t layout = 1;
  for (const bool chunk : settings.chunks) layout = 2 * layout + (chunk ? 1U : 0U);
  return layout;
}

}  // namespace

StreamBlock::StreamBlock(const FrameOrder& order, std::vector<std::uint8_t> image, std::uint32_t packet_bytes)
    : id_(order.block),
      room_(packet_bytes - gige::kWireHeaderBytes - gige::kStreamHeaderBytes),
      packets_(0),
      payload_(std::move(image)) {
  const CameraSettings& settings = order.settings;
  RIGCAL_ASSERT(payload_.size() == settings.image_bytes, "an image of another size");
  if (settings.has_chunks) append_chunks(order, payload_);
  packets_ = static_cast<std::uint32_t>((payload_.size() + room_ - 1) / room_) + 2;
  gige::ImageLeader leader;
  leader.has_chunks = settings.has_chunks;
  leader.timestamp = order.ticks;
  leader.pixel_format = settings.pixel_format;
  leader.width = static_cast<std::uint32_t>(settings.width);
  leader.height = static_cast<std::uint32_t>(settings.height);
  leader.offset_x = static_cast<std::uint32_t>(settings.offset_x);
  leader.offset_y = static_cast<std::uint32_t>(settings.offset_y);
  leader_ = gige::encode_leader(leader);
  trailer_ = gige::encode_trailer({settings.has_chunks, leader.height, layout_of(settings)});
}

StreamBlock::Packet StreamBlock::packet(std::uint32_t number, gige::Status status) const {
  RIGCAL_ASSERT(number < packets_, "a packet that the block does not have");
  gige::StreamPacket packet;
  packet.status = status;
  packet.block = id_;
  packet.packet = number;
  if (number == 0) {
    packet.kind = gige::PacketKind::leader;
    packet.payload = leader_;
  } else if (number == packets_ - 1) {
    packet.kind = gige::PacketKind::trailer;
    packet.payload = trailer_;
  } else {
    const std::size_t at = (number - 1) * room_;
    packet.payload = ByteView(payload_).subspan(at, std::min(room_, payload_.size() - at));
  }
  return {gige::make_stream_header(packet), packet.payload};
}

}  // namespace rigcal::sim
