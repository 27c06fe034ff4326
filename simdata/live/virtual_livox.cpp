#include "simdata/live/virtual_livox.h"

#include <algorithm>
#include <utility>

#include "core/base/seconds.h"
#include "drivers/livox_codec/status.h"

namespace rigcal::sim {
namespace {

using livox::ReturnCode;
using livox::WorkState;

constexpr std::int64_t status_period_ns = 100'000'000;
constexpr std::size_t most_delayed = 64;

bool is_error(std::uint32_t status) { return livox::decode_status(status).system == livox::Level::error; }

}  // namespace

VirtualLivox::VirtualLivox(VirtualLivoxOptions options, std::int64_t now_ns)
    : options_(std::move(options)),
      settings_(options_.identity, options_.ip,
                options_.firmware.value_or(livox::facts_of(options_.identity.type).livox.newest_firmware)),
      time_(options_.time),
      random_(options_.seed) {
  start(now_ns);
  is_dark_ = false;
}

void VirtualLivox::start(std::int64_t now_ns) {
  booted_ns_ = now_ns;
  owner_.reset();
  is_sampling_ = false;
  reboot_due_ns_.reset();
  time_.restart();
  delayed_.clear();
  message_seq_ = 0;
  broadcast_due_ns_ = now_ns;
  status_due_ns_ = now_ns;
  spin_up(now_ns);
}

void VirtualLivox::spin_up(std::int64_t now_ns) {
  work_state_ = WorkState::initialising;
  spun_up_ns_ = now_ns + ns_of_seconds(options_.spin_up_s);
}

void VirtualLivox::reboot(std::int64_t now_ns) {
  start(now_ns + ns_of_seconds(options_.boot_s));
  is_dark_ = true;
  dark_until_ns_ = booted_ns_;
}

void VirtualLivox::set_status(std::uint32_t status) {
  const bool was_error = is_error(status_);
  status_ = status;
  if (is_error(status)) {
    work_state_ = WorkState::error;
    is_sampling_ = false;
  } else if (was_error) {
    work_state_ = WorkState::initialising;  // Spins up again, from the next tick on.
    spun_up_ns_ = INT64_MIN;
  }
}

void VirtualLivox::release(std::int64_t now_ns) {
  owner_.reset();
  is_sampling_ = false;
  broadcast_due_ns_ = now_ns;
}

void VirtualLivox::tick(std::int64_t now_ns, std::vector<DeviceFrame>& out) {
  if (reboot_due_ns_ && now_ns >= *reboot_due_ns_) reboot(*reboot_due_ns_);
  if (is_dark_ && now_ns < dark_until_ns_) return;
  is_dark_ = false;
  time_.tick(now_ns);
  if (work_state_ == WorkState::initialising && spun_up_ns_ == INT64_MIN) spin_up(now_ns);
  if (work_state_ == WorkState::initialising && now_ns >= spun_up_ns_) work_state_ = WorkState::normal;
  if (owner_ && now_ns - heartbeat_ns_ >= ns_of_seconds(options_.owner_timeout_s)) release(now_ns);
  if (now_ns < silent_until_ns_) return;
  for (auto it = delayed_.begin(); it != delayed_.end();) {
    if (it->due_ns > now_ns) {
      ++it;
      continue;
    }
    out.push_back(std::move(it->frame));
    it = delayed_.erase(it);
  }
  if (!owner_ && !is_owned_by_other_ && now_ns >= broadcast_due_ns_) {
    broadcast_due_ns_ = now_ns + ns_of_seconds(options_.broadcast_s);
    send(now_ns, options_.broadcast_to, livox::make_broadcast(options_.identity, message_seq_++), out);
  }
  const bool abnormal = livox::decode_status(status_).system != livox::Level::normal;
  if (owner_ && abnormal && now_ns >= status_due_ns_) {
    status_due_ns_ = now_ns + status_period_ns;
    send(now_ns, {owner_->ip, owner_->command_port},
         livox::encode_control(livox::AbnormalStatus{status()}, message_seq_++), out);
  }
}

std::int64_t VirtualLivox::deadline_ns() const {
  std::int64_t deadline = INT64_MAX;
  const auto sooner = [&deadline](std::int64_t time_ns) { deadline = std::min(deadline, time_ns); };
  if (reboot_due_ns_) sooner(*reboot_due_ns_);
  if (is_dark_) {
    sooner(dark_until_ns_);
    return deadline;
  }
  if (work_state_ == WorkState::initialising) sooner(spun_up_ns_);
  if (const auto lapse = time_.deadline_ns()) sooner(*lapse);
  if (owner_) sooner(heartbeat_ns_ + ns_of_seconds(options_.owner_timeout_s));
  const auto speaks_at = [&](std::int64_t time_ns) { sooner(std::max(time_ns, silent_until_ns_)); };
  if (!owner_ && !is_owned_by_other_) speaks_at(broadcast_due_ns_);
  if (owner_ && livox::decode_status(status_).system != livox::Level::normal) speaks_at(status_due_ns_);
  for (const Delayed& delayed : delayed_) speaks_at(delayed.due_ns);
  return deadline;
}

void VirtualLivox::receive(std::int64_t now_ns, const Endpoint& from, ByteView bytes, std::vector<DeviceFrame>& out) {
  tick(now_ns, out);
  if (is_silent(now_ns)) return;
  const auto frame = livox::parse_control_frame(bytes);
  if (!frame || !livox::is_request(*frame)) return;
  if (refused_.count(livox::command_of(*frame)) > 0) return send(now_ns, from, livox::make_refusal(*frame), out);
  if (livox::command_of(*frame) == livox::Command::handshake) return shake_hands(now_ns, from, *frame, out);
  const bool is_owner = owner_ && owner_->ip == from.ip;
  // Nobody's heartbeat is answered but the owner's: the others would believe that they have it.
  if (!is_owner && livox::command_of(*frame) == livox::Command::heartbeat) return;
  const auto request = livox::decode_control(*frame);
  const auto reply = is_owner && request ? answer(now_ns, *request) : std::nullopt;
  std::uint16_t seq = frame->seq;
  if (happens(options_.faults.wrong_number)) ++seq;
  send(now_ns, from, reply ? livox::encode_control(*reply, seq) : livox::make_refusal(*frame), out);
}

void VirtualLivox::shake_hands(std::int64_t now_ns, const Endpoint& from, const livox::ControlFrame& frame,
                               std::vector<DeviceFrame>& out) {
  const auto handshake = livox::parse_handshake(frame);
  const bool is_taken = is_owned_by_other_ || (owner_ && handshake && owner_->ip != handshake->host_ip);
  const bool is_usable = handshake && handshake->data_port != 0;  // No packet can be sent to port 0.
  if (!is_usable || is_taken) return send(now_ns, from, livox::make_refusal(frame), out);
  owner_ = Owner{handshake->host_ip, handshake->command_port, handshake->data_port,
                 handshake->imu_port.value_or(handshake->data_port)};
  heartbeat_ns_ = now_ns;
  send(now_ns, from, livox::encode_control(livox::HandshakeAck{}, frame.seq), out);
}

livox::HeartbeatAck VirtualLivox::heartbeat(std::int64_t now_ns) const {
  livox::HeartbeatAck ack;
  ack.state = work_state_;
  ack.features = settings_.suppresses_rain() ? 1 : 0;
  ack.progress_or_status = status();
  if (work_state_ == WorkState::initialising) {
    const double left = seconds_of_ns(spun_up_ns_ - now_ns) / options_.spin_up_s;
    ack.progress_or_status = static_cast<std::uint32_t>(std::clamp(100.0 * (1.0 - left), 0.0, 100.0));
  }
  return ack;
}

std::optional<livox::ControlPayload> VirtualLivox::switch_power(std::int64_t now_ns, livox::PowerMode mode) {
  if (work_state_ == WorkState::error) return std::nullopt;
  if (mode == livox::PowerMode::normal) {
    if (work_state_ == WorkState::normal) return livox::SetPowerModeAck{};
    if (work_state_ != WorkState::initialising) spin_up(now_ns);
    return livox::SetPowerModeAck{ReturnCode::switching};
  }
  is_sampling_ = false;
  work_state_ = mode == livox::PowerMode::standby ? WorkState::standby : WorkState::power_saving;
  return livox::SetPowerModeAck{};
}

std::optional<livox::ControlPayload> VirtualLivox::answer(std::int64_t now_ns, const livox::ControlPayload& request) {
  if (std::holds_alternative<livox::HeartbeatRequest>(request)) {
    heartbeat_ns_ = now_ns;
    return heartbeat(now_ns);
  }
  if (const auto* sampling = std::get_if<livox::SamplingRequest>(&request)) {
    const bool start = sampling->value == livox::Sampling::start;
    if (start && work_state_ != WorkState::normal) return std::nullopt;
    is_sampling_ = start;
    return livox::SamplingAck{};
  }
  if (const auto* power = std::get_if<livox::SetPowerModeRequest>(&request)) return switch_power(now_ns, power->value);
  if (std::holds_alternative<livox::DisconnectRequest>(request)) {
    release(now_ns + ns_of_seconds(options_.broadcast_s));
    return livox::DisconnectAck{};
  }
  if (const auto* delay = std::get_if<livox::RebootRequest>(&request)) {
    reboot_due_ns_ = now_ns + std::int64_t{delay->value} * 1'000'000;
    return livox::RebootAck{};
  }
  if (const auto* utc = std::get_if<livox::SetUtcTimeRequest>(&request)) {
    if (!time_.set_utc(now_ns, utc->value.unix_ns)) return std::nullopt;
    return livox::SetUtcTimeAck{};
  }
  return settings_.answer(request);
}

void VirtualLivox::send(std::int64_t now_ns, const Endpoint& to, std::vector<std::uint8_t> bytes,
                        std::vector<DeviceFrame>& out) {
  const ControlFaults& faults = options_.faults;
  if (happens(faults.drop)) return;
  if (happens(faults.wrong_checksum)) bytes[random_.below(bytes.size())] ^= 0x10U;
  if (happens(faults.duplicate)) out.push_back({to, bytes});
  if (happens(faults.delay) && delayed_.size() < most_delayed) {
    delayed_.push_back({now_ns + ns_of_seconds(random_.uniform(0.0, faults.longest_delay_s)), {to, std::move(bytes)}});
    return;
  }
  out.push_back({to, std::move(bytes)});
}

}  // namespace rigcal::sim
