#include "drivers/livox_codec/control_payload.h"

#include <memory>
#include <utility>

#include "drivers/livox_codec/payload_io.h"

namespace rigcal::livox {
namespace {

template <class T>
concept IsAck = T::type == FrameType::ack;

/// Payloads that are read and written by their fields, all but the three that frame their own.
template <class T>
concept ByFields = HasFields<T> && requires {
  T::command;
};

template <ByFields T>
Expected<ControlPayload> decode_fields(const ControlFrame& frame) {
  T payload{};
  if constexpr (IsAck<T>) {
    if (frame.payload.size() == 1 && frame.payload[0] != 0) {
      payload.ret = static_cast<ReturnCode>(frame.payload[0]);
      return ControlPayload(std::move(payload));
    }
  }
  PayloadReader reader(frame.payload, !IsAck<T>);
  reader.read(payload);
  reader.finish();
  if constexpr (requires { payload.mistake(); }) {
    if (const char* mistake = payload.mistake()) reader.fail(mistake);
  }
  if (reader.mistake().empty()) return ControlPayload(std::move(payload));
  return input_error(reader.mistake(), frame_name(frame) + ", offset " + std::to_string(reader.offset()) +
                                           " of a payload of " + std::to_string(frame.payload.size()) + " bytes");
}

template <class T>
bool decode_if(const ControlFrame& frame, Expected<ControlPayload>& out) {
  if constexpr (ByFields<T>) {
    if (command_of(frame) == T::command && frame.type == T::type) {
      out = decode_fields<T>(frame);
      return true;
    }
  }
  return false;
}

template <std::size_t... index>
Expected<ControlPayload> decode_any(const ControlFrame& frame, std::index_sequence<index...>) {
  Expected<ControlPayload> out =
      ControlPayload(RawControl{frame.type, frame.set, frame.id, {frame.payload.begin(), frame.payload.end()}});
  static_cast<void>((decode_if<std::variant_alternative_t<index, ControlContent>>(frame, out) || ...));
  return out;
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
  return decode_any(frame, std::make_index_sequence<std::variant_size_v<ControlContent>>());
}

std::vector<std::uint8_t> encode_control(const ControlPayload& payload, std::uint16_t seq) {
  return std::visit([seq](const auto& content) { return encode(content, seq); }, payload);
}

std::vector<std::uint8_t> make_refusal(const ControlFrame& request) {
  const std::uint8_t ret = static_cast<std::uint8_t>(ReturnCode::failure);
  return make_control_frame({FrameType::ack, request.seq, request.set, request.id, {&ret, 1}});
}

}  // namespace rigcal::livox
