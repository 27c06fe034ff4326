// GigE Vision commands, acks and stream packets of any bytes: refused, or the same again after writing, never read past
// the end.
#include <cstdint>

#include "core/base/error.h"
#include "drivers/gige_codec/ack.h"
#include "drivers/gige_codec/chunks.h"
#include "drivers/gige_codec/stream_packet.h"

namespace {

using namespace rigcal::gige;

void check_command(rigcal::ByteView bytes) {
  const auto frame = parse_command(bytes);
  if (!frame) return;
  RIGCAL_ASSERT(parse_ack(make_refusal(*frame, Status::error)).has_value(), "a refusal that is no ack");
  const auto request = decode_request(*frame);
  if (!request) return;
  const auto again = encode_request(*request, frame->id);
  const auto back = parse_command(again);
  RIGCAL_ASSERT(back && back->command == frame->command, "another command");
  const auto same = decode_request(*back);
  RIGCAL_ASSERT(same && *same == *request, "a request has changed");
}

void check_ack(rigcal::ByteView bytes) {
  const auto frame = parse_ack(bytes);
  if (!frame) return;
  const auto ack = decode_ack(*frame);
  if (!ack) return;
  const auto again = encode_ack(*ack, frame->id, frame->status);
  const auto back = decode_ack(*parse_ack(again));
  // Texts that fill their field without an end mark are read, but never written.
  RIGCAL_ASSERT(back.has_value() && encode_ack(*back, frame->id, frame->status) == again, "an ack has changed");
}

void check_packet(rigcal::ByteView bytes) {
  const auto packet = parse_stream_packet(bytes);
  if (!packet) return;
  const auto header = make_stream_header(*packet);
  const auto again = parse_stream_packet(header);
  RIGCAL_ASSERT(again && again->packet == packet->packet && again->kind == packet->kind, "a header has changed");
  if (const auto leader = decode_leader(packet->payload))
    RIGCAL_ASSERT(*decode_leader(encode_leader(*leader)) == *leader, "a leader has changed");
  if (const auto trailer = decode_trailer(packet->payload))
    RIGCAL_ASSERT(*decode_trailer(encode_trailer(*trailer)) == *trailer, "a trailer has changed");
}

void check_chunks(rigcal::ByteView bytes) {
  const auto chunks = split_chunks(bytes);
  if (!chunks) return;
  std::size_t all = 0;
  for (const Chunk& chunk : *chunks) all += chunk.bytes.size() + kChunkTagBytes;
  RIGCAL_ASSERT(all == bytes.size(), "chunks that are not the whole block");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  const rigcal::ByteView view(bytes, size);
  check_command(view);
  check_ack(view);
  check_packet(view);
  check_chunks(view);
  return 0;
}
