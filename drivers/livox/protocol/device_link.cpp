#include "drivers/livox/protocol/device_link.h"

#include <algorithm>
#include <utility>

#include "drivers/livox/protocol/abilities.h"
#include "drivers/livox_codec/status.h"

namespace rigcal::livox {

const char* to_string(LinkState state) {
  switch (state) {
    case LinkState::waiting:
      return "waiting";
    case LinkState::handshaking:
      return "handshaking";
    case LinkState::identifying:
      return "identifying";
    case LinkState::preparing:
      return "preparing";
    case LinkState::configuring:
      return "configuring";
    case LinkState::resting:
      return "resting";
    case LinkState::idle:
      return "idle";
    case LinkState::sampling:
      return "sampling";
    case LinkState::leaving:
      return "leaving";
    case LinkState::closed:
      return "closed";
  }
  return "?";
}

DeviceLink::DeviceLink(std::size_t index, WantedDevice wanted) : index_(index), wanted_(std::move(wanted)) {
  info_.broadcast.broadcast_code = wanted_.broadcast_code;
  if (wanted_.ip) info_.ip = *wanted_.ip;
}

bool DeviceLink::is_connected() const {
  switch (info_.state) {
    case LinkState::waiting:
    case LinkState::handshaking:
    case LinkState::closed:
      return false;
    default:
      return true;
  }
}

void DeviceLink::receive_broadcast(std::int64_t now_ns, const Broadcast& broadcast, const Endpoint& from,
                                   const HostAddress& host, std::size_t host_index, ProtocolOutput& out) {
  if (info_.state == LinkState::handshaking || info_.state == LinkState::leaving || info_.state == LinkState::closed)
    return;
  if (info_.state != LinkState::waiting) {
    if (now_ns - life_ns_ < kLetGoNs) return;
    lose(now_ns, LossCause::let_go, out);
  }
  if (last_handshake_ns_ && now_ns - *last_handshake_ns_ < kAnswerNs) return;
  info_.broadcast = broadcast;
  info_.ip = from.ip;
  broadcast_from_ = from;
  host_ = host;
  host_index_ = host_index;
  shake_hands(now_ns, out);
}

void DeviceLink::shake_hands(std::int64_t now_ns, ProtocolOutput& out) {
  // Old firmware has a shorter form, and some hosts send it as an ack: where the model's usual way was not answered or
  // not taken, the other one is tried the next time. One that was taken is the one for the next time, too.
  const bool short_form = (info_.broadcast.type == DeviceType::mid40) != tries_other_form_;
  Handshake handshake{host_.ip, host_.data_port, host_.command_port, host_.imu_port};
  if (short_form) handshake.imu_port.reset();
  handshake_seq_ = next_seq();
  send(broadcast_from_, make_handshake(handshake, handshake_seq_, short_form ? FrameType::command : FrameType::ack),
       out);
  ++info_.counters.handshakes;
  last_handshake_ns_ = now_ns;
  handshake_due_ns_ = now_ns + kAnswerNs;
  info_.state = LinkState::handshaking;
}

void DeviceLink::receive_frame(std::int64_t now_ns, const ControlFrame& frame, ProtocolOutput& out) {
  if (info_.state == LinkState::waiting || info_.state == LinkState::closed || frame.type == FrameType::command) {
    ++info_.counters.stray_acks;
    return;
  }
  if (frame.type == FrameType::ack) {
    take_ack(now_ns, frame, out);
    return;
  }
  if (command_of(frame) != Command::abnormal_status || !is_connected()) return;
  const auto payload = decode_control(frame);
  if (!payload) {
    ++info_.counters.unreadable;
    return;
  }
  if (const auto* abnormal = std::get_if<AbnormalStatus>(&*payload)) note_status(now_ns, abnormal->status, out);
}

void DeviceLink::take_ack(std::int64_t now_ns, const ControlFrame& frame, ProtocolOutput& out) {
  const Command command = command_of(frame);
  const bool handshake =
      info_.state == LinkState::handshaking && command == Command::handshake && frame.seq == handshake_seq_;
  const bool heartbeat = is_connected() && command == Command::heartbeat && is_own_heartbeat(frame.seq);
  const bool answer = exchange_ && command == exchange_->command && frame.seq == exchange_->seq;
  const bool utc = command == Command::set_utc_time && utc_seq_ == frame.seq;
  if (!handshake && !heartbeat && !answer && !utc) {
    ++info_.counters.stray_acks;
    return;
  }
  const auto payload = decode_control(frame);
  if (!payload) {
    ++info_.counters.unreadable;
    return;
  }
  if (handshake) return take_handshake_ack(now_ns, *payload, out);
  if (utc) {
    utc_seq_.reset();
    const auto* ack = std::get_if<SetUtcTimeAck>(&*payload);
    ++(ack != nullptr && ack->ret == ReturnCode::success ? info_.counters.utc_taken : info_.counters.utc_refused);
    return;
  }
  if (const auto* ack = std::get_if<HeartbeatAck>(&*payload)) return take_heartbeat_ack(now_ns, *ack, out);
  const auto ret = std::visit(
      [](const auto& content) {
        if constexpr (requires { content.ret; }) return content.ret;
        return ReturnCode::failure;
      },
      *payload);
  if (const auto* ack = std::get_if<DeviceInformationAck>(&*payload)) {
    // One that does not say who it is is asked again when the time is over.
    if (ret == ReturnCode::success) identify(now_ns, *ack, out);
    return;
  }
  const bool switching = ret == ReturnCode::switching && command == Command::set_power_mode;
  finish(now_ns,
         ret == ReturnCode::success ? Outcome::done
         : switching                ? Outcome::switching
                                    : Outcome::refused,
         *payload, out);
}

void DeviceLink::take_handshake_ack(std::int64_t now_ns, const ControlPayload& payload, ProtocolOutput& out) {
  const auto* ack = std::get_if<HandshakeAck>(&payload);
  if (ack == nullptr || ack->ret != ReturnCode::success) {
    info_.state = LinkState::waiting;
    tries_other_form_ = !tries_other_form_;
    return tell(now_ns, HandshakeRefused{}, out);
  }
  info_.state = LinkState::identifying;
  info_.work_state = WorkState::initialising;
  info_.progress_percent = 0;
  life_ns_ = now_ns;
  heartbeat_due_ns_ = now_ns;
  heartbeats_.fill({});
  utc_seq_.reset();
  sampling_due_ns_ = now_ns;
  power_due_ns_ = now_ns;
  tick(now_ns, out);
}

void DeviceLink::take_heartbeat_ack(std::int64_t now_ns, const HeartbeatAck& ack, ProtocolOutput& out) {
  if (ack.ret != ReturnCode::success) {
    ++info_.counters.refused_heartbeats;  // It does not take this host for its own: no sign of life.
    return;
  }
  life_ns_ = now_ns;
  info_.features = ack.features;
  const WorkState before = info_.work_state;
  info_.work_state = ack.state;
  if (ack.state != before) tell(now_ns, WorkStateChanged{before, ack.state}, out);
  if (ack.state == WorkState::initialising) {
    info_.progress_percent = ack.progress_or_status;
  } else {
    note_status(now_ns, ack.progress_or_status, out);
  }
  const bool set_up = info_.state == LinkState::configuring || info_.state == LinkState::resting ||
                      info_.state == LinkState::idle || info_.state == LinkState::sampling;
  if (set_up && !is_wanted_work_state()) prepare(now_ns, false, out);
  advance(now_ns, out);
}

void DeviceLink::tell_utc(std::int64_t unix_ns, ProtocolOutput& out) {
  const SetUtcTimeRequest request{{unix_ns}};
  const bool is_known = is_connected() && info_.state != LinkState::identifying && info_.state != LinkState::leaving;
  if (!is_known || !decode_status(info_.status).pps_ok) return;
  if (!can_do(info_.broadcast.type, info_.firmware, request) || !can_send(request)) return;
  utc_seq_ = next_seq();
  send({info_.ip, kDevicePort}, encode_control(request, *utc_seq_), out);
}

void DeviceLink::note_status(std::int64_t now_ns, std::uint32_t word, ProtocolOutput& out) {
  if (word == info_.status) return;
  tell(now_ns, StatusChanged{info_.status, word}, out);
  info_.status = word;
}

bool DeviceLink::is_own_heartbeat(std::uint16_t seq) {
  const auto found = std::find(heartbeats_.begin(), heartbeats_.end(), seq);
  if (found == heartbeats_.end()) return false;
  found->reset();
  return true;
}

bool DeviceLink::is_wanted_work_state() const {
  switch (wanted_.power) {
    case PowerMode::normal:
      return info_.work_state == WorkState::normal;
    case PowerMode::power_saving:
      return info_.work_state == WorkState::power_saving;
    case PowerMode::standby:
      return info_.work_state == WorkState::standby;
  }
  return false;
}

void DeviceLink::tick(std::int64_t now_ns, ProtocolOutput& out) {
  if (info_.state == LinkState::handshaking && now_ns >= handshake_due_ns_) {
    info_.state = LinkState::waiting;
    tries_other_form_ = !tries_other_form_;
    return tell(now_ns, HandshakeUnanswered{}, out);
  }
  if (!is_connected()) return;
  if (info_.state == LinkState::leaving && now_ns >= leave_end_ns_) return close(now_ns, out);
  if (now_ns - life_ns_ >= kSilenceNs) {
    if (info_.state == LinkState::leaving) return close(now_ns, out);
    return lose(now_ns, LossCause::silence, out);
  }
  if (exchange_ && now_ns >= exchange_->due_ns) {
    if (exchange_->attempts_left > 0) {
      --exchange_->attempts_left;
      exchange_->due_ns = now_ns + kAnswerNs;
      ++info_.counters.repeated;
      send({info_.ip, kDevicePort}, exchange_->bytes, out);
    } else {
      finish(now_ns, Outcome::unanswered, RawControl{}, out);
    }
  }
  if (is_connected() && now_ns >= heartbeat_due_ns_) {
    heartbeat_due_ns_ = now_ns + (heartbeats_[0] ? kHeartbeatRetryNs : kHeartbeatPeriodNs);
    std::move_backward(heartbeats_.begin(), heartbeats_.end() - 1, heartbeats_.end());
    heartbeats_[0] = next_seq();
    send({info_.ip, kDevicePort}, encode_control(HeartbeatRequest{}, *heartbeats_[0]), out);
  }
  advance(now_ns, out);
}

std::optional<std::int64_t> DeviceLink::deadline_ns() const {
  if (info_.state == LinkState::handshaking) return handshake_due_ns_;
  if (!is_connected()) return std::nullopt;
  std::int64_t deadline = std::min(heartbeat_due_ns_, life_ns_ + kSilenceNs);
  if (exchange_) deadline = std::min(deadline, exchange_->due_ns);
  if (info_.state == LinkState::leaving) deadline = std::min(deadline, leave_end_ns_);
  return deadline;
}

std::uint16_t DeviceLink::next_seq() {
  ++seq_;
  if (seq_ == 0) seq_ = 1;
  return seq_;
}

void DeviceLink::send(const Endpoint& to, std::vector<std::uint8_t> bytes, ProtocolOutput& out) const {
  out.frames.push_back({host_index_, to, std::move(bytes)});
}

void DeviceLink::tell(std::int64_t now_ns, EventContent content, ProtocolOutput& out) const {
  out.events.push_back({now_ns, index_, std::move(content)});
}

}  // namespace rigcal::livox
