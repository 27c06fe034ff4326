#include "drivers/livox_codec/control_payload.h"

#include <memory>
#include <utility>

#include "drivers/livox_codec/payload_io.h"

namespace rigcal::livox {

// Not in line: every payload says what is wrong with its fields.
void PayloadReader::fail(std::string_view mistake) {
  if (mistake_.empty()) mistake_ = mistake;
}

namespace {

template <class T>
concept IsAck = T::type == FrameType::ack;

/// Payloads that are read and written by their fields, all but the three that frame their own.
template <class T>
concept ByFields = HasFields<T> && requires {
  T::command;
};

template <ByFields T>
void decode_fields(const ControlFrame& frame, PayloadReader& reader, T& payload) {
  if constexpr (IsAck<T>) {
    if (frame.payload.size() == 1 && frame.payload[0] != 0) {
      payload.ret = static_cast<ReturnCode>(frame.payload[0]);
      return;
    }
  }
  reader.be_strict(!IsAck<T>);
  reader.read(payload);
  reader.finish();
  if constexpr (requires { payload.mistake(); }) {
    if (const char* mistake = payload.mistake()) reader.fail(mistake);
  }
}

/// Whether the frame is that one; what is wrong with its payload is the reader's to say.
template <std::size_t index>
bool decode_if(const ControlFrame& frame, PayloadReader& reader, ControlContent& out) {
  using T = std::variant_alternative_t<index, ControlContent>;
  if constexpr (ByFields<T>) {
    if (command_of(frame) == T::command && frame.type == T::type) {
      decode_fields(frame, reader, out.emplace<index>());
      return true;
    }
  }
  return false;
}

template <std::size_t... index>
bool decode_any(const ControlFrame& frame, PayloadReader& reader, ControlContent& out, std::index_sequence<index...>) {
  return (decode_if<index>(frame, reader, out) || ...);
}

template <class T>
Expected<ControlPayload> widened(Expected<T> payload) {
  if (!payload) return payload.error();
  return ControlPayload(std::move(*payload));
}

std::vector<std::uint8_t> encode(const RawControl& raw, std::uint16_t seq) {
  return make_control_frame({raw.type, seq, raw.set, raw.id, raw.payload});
}

std::vector<std::uint8_t> encode(const Broadcast& broadcast, std::uint16_t seq) {
  return make_broadcast(broadcast, seq);
}

std::vector<std::uint8_t> encode(const Handshake& handshake, std::uint16_t seq) {
  return make_handshake(handshake, seq);
}

template <ByFields T>
std::vector<std::uint8_t> encode(const T& payload, std::uint16_t seq) {
  std::vector<std::uint8_t> bytes;
  PayloadWriter(bytes).write(payload);
  return make_control_frame(frame_of(T::command, T::type, seq, bytes));
}

}  // namespace

ControlPayload::ControlPayload() noexcept = default;
ControlPayload::ControlPayload(const ControlPayload& other) = default;
ControlPayload::ControlPayload(ControlPayload&& other) noexcept = default;
ControlPayload::~ControlPayload() = default;

// The other one is a copy of its own, and to move it cannot fail.
ControlPayload& ControlPayload::operator=(ControlPayload other) noexcept {
  std::destroy_at(this);
  return *std::construct_at(this, std::move(other));
}

Expected<ControlPayload> decode_control(const ControlFrame& frame) {
  if (is_broadcast(frame)) return widened(parse_broadcast(frame));
  const bool asks_for_handshake = frame.type == FrameType::command && command_of(frame) == Command::handshake;
  if (asks_for_handshake || is_handshake(frame)) return widened(parse_handshake(frame));
  ControlPayload payload;
  PayloadReader reader(frame.payload);
  if (!decode_any(frame, reader, payload, std::make_index_sequence<std::variant_size_v<ControlContent>>())) {
    return ControlPayload(RawControl{frame.type, frame.set, frame.id, {frame.payload.begin(), frame.payload.end()}});
  }
  if (reader.mistake().empty()) return payload;
  return input_error(reader.mistake(), frame_name(frame) + ", offset " + std::to_string(reader.offset()) +
                                           " of a payload of " + std::to_string(frame.payload.size()) + " bytes");
}

std::vector<std::uint8_t> encode_control(const ControlPayload& payload, std::uint16_t seq) {
  return std::visit([seq](const auto& content) { return encode(content, seq); }, payload);
}

std::vector<std::uint8_t> make_refusal(const ControlFrame& request) {
  const std::uint8_t ret = static_cast<std::uint8_t>(ReturnCode::failure);
  return make_control_frame({FrameType::ack, request.seq, request.set, request.id, {&ret, 1}});
}

}  // namespace rigcal::livox
