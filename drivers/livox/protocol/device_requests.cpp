// The requests of a link: what it asks next, and what becomes of it.
#include <utility>

#include "drivers/livox/protocol/abilities.h"
#include "drivers/livox/protocol/device_link.h"

namespace rigcal::livox {
namespace {

bool is_command(const ControlPayload& payload) {
  return std::visit(
      [](const auto& content) {
        using Content = std::decay_t<decltype(content)>;
        if constexpr (requires { Content::command; }) return Content::type == FrameType::command;
        return false;
      },
      payload);
}

// What the link asks for itself: a user's would confuse it.
bool is_own_request(Command command) {
  return command == Command::heartbeat || command == Command::sampling || command == Command::set_power_mode;
}

}  // namespace

void DeviceLink::start(std::int64_t now_ns, const ControlPayload& request, Purpose purpose, ProtocolOutput& out) {
  Exchange exchange;
  exchange.purpose = purpose;
  exchange.command = command_of(request);
  exchange.seq = next_seq();
  exchange.attempts_left = kAttempts - 1;
  if (purpose == Purpose::identify) exchange.attempts_left = INT32_MAX;  // Until the heartbeats fail.
  if (purpose == Purpose::leave) exchange.attempts_left = 0;
  if (exchange.command == Command::set_utc_time) exchange.attempts_left = 0;  // It would come too late for its pulse.
  exchange.due_ns = now_ns + kAnswerNs;
  exchange.bytes = encode_control(request, exchange.seq);
  send({info_.ip, kDevicePort}, exchange.bytes, out);
  exchange_ = std::move(exchange);
}

void DeviceLink::identify(std::int64_t now_ns, const DeviceInformationAck& ack, ProtocolOutput& out) {
  exchange_.reset();
  info_.firmware = ack.value;
  tell(now_ns, Connected{info_.broadcast.type, info_.firmware, info_.ip}, out);
  setup_.clear();
  for (ControlPayload& request : setup_requests(wanted_.settings)) {
    if (can_do(info_.broadcast.type, info_.firmware, request)) {
      setup_.push_back({std::move(request), Outcome::done});
      continue;
    }
    const bool is_met = is_met_unknown(request);
    tell(now_ns,
         RequestEnded{command_of(request), Outcome::unsupported, RawControl{},
                      is_met ? std::string() : setting_text(request)},
         out);
    if (!is_met) setup_.push_back({std::move(request), Outcome::unsupported});
  }
  list_missing_settings();
  info_.state = LinkState::preparing;
  advance(now_ns, out);
}

void DeviceLink::start_setting(std::int64_t now_ns, std::size_t step, ProtocolOutput& out) {
  start(now_ns, setup_[step].request, Purpose::setup, out);
  exchange_->step = step;
}

// One after the other, so that one which is never answered keeps no other from it.
bool DeviceLink::retry_setting(std::int64_t now_ns, ProtocolOutput& out) {
  const bool is_set_up = info_.state == LinkState::idle || info_.state == LinkState::sampling;
  if (!is_set_up || now_ns < setting_due_ns_) return false;
  for (std::size_t i = 0; i < setup_.size(); ++i) {
    const std::size_t step = (retry_step_ + i) % setup_.size();
    if (setup_[step].outcome != Outcome::unanswered) continue;
    retry_step_ = step + 1;
    start_setting(now_ns, step, out);
    return true;
  }
  return false;
}

void DeviceLink::finish_setting(std::int64_t now_ns, const Exchange& exchange, Outcome outcome, ControlPayload answer,
                                ProtocolOutput& out) {
  SetupStep& step = setup_[exchange.step];
  const Outcome before = std::exchange(step.outcome, outcome);
  if (outcome == Outcome::unanswered) setting_due_ns_ = now_ns + kSettingRetryNs;
  list_missing_settings();
  const bool is_changed = outcome != before;
  if (!is_changed && outcome != Outcome::done) return;  // Told already.
  std::string setting = is_changed ? setting_text(step.request) : std::string();
  tell(now_ns, RequestEnded{exchange.command, outcome, std::move(answer), std::move(setting)}, out);
}

void DeviceLink::list_missing_settings() {
  info_.missing_settings.clear();
  for (const SetupStep& step : setup_)
    if (step.outcome != Outcome::done) info_.missing_settings.push_back({setting_text(step.request), step.outcome});
}

void DeviceLink::finish(std::int64_t now_ns, Outcome outcome, ControlPayload answer, ProtocolOutput& out) {
  const Exchange exchange = std::move(*exchange_);
  exchange_.reset();
  if (exchange.purpose == Purpose::setup) {
    finish_setting(now_ns, exchange, outcome, std::move(answer), out);
  } else if (exchange.purpose != Purpose::leave) {
    tell(now_ns, RequestEnded{exchange.command, outcome, std::move(answer)}, out);
  }
  finish_request(now_ns, exchange, outcome, out);
  advance(now_ns, out);
}

void DeviceLink::finish_request(std::int64_t now_ns, const Exchange& exchange, Outcome outcome, ProtocolOutput& out) {
  const bool done = outcome == Outcome::done;
  if (exchange.purpose == Purpose::sampling) {
    if (!done) {
      sampling_due_ns_ = now_ns + kSamplingRetryNs;
    } else if (info_.state == LinkState::idle || info_.state == LinkState::sampling) {
      info_.state = sampling_asked_ ? LinkState::sampling : LinkState::idle;
      tell(now_ns, SamplingChanged{sampling_asked_}, out);
    }
  }
  if (exchange.purpose != Purpose::user || !done) return;
  if (exchange.command == Command::reboot) lose(now_ns, LossCause::rebooting, out);
  if (exchange.command == Command::disconnect) lose(now_ns, LossCause::disconnected, out);
}

void DeviceLink::advance(std::int64_t now_ns, ProtocolOutput& out) {
  while (!exchange_ && advance_once(now_ns, out)) {
  }
}

// One step; false where only time or the device can help.
bool DeviceLink::advance_once(std::int64_t now_ns, ProtocolOutput& out) {
  const bool wants_user = !requests_.empty() && is_connected() && info_.state != LinkState::identifying &&
                          info_.state != LinkState::configuring && info_.state != LinkState::leaving;
  switch (info_.state) {
    case LinkState::identifying:
      start(now_ns, DeviceInformationRequest{}, Purpose::identify, out);
      return true;
    case LinkState::preparing: {
      if (is_wanted_work_state()) {
        info_.state = wanted_.power == PowerMode::normal ? LinkState::configuring : LinkState::resting;
        setup_step_ = 0;
        return true;
      }
      const bool can_switch = info_.work_state == WorkState::normal || info_.work_state == WorkState::power_saving ||
                              info_.work_state == WorkState::standby;
      if (!can_switch || now_ns < power_due_ns_) break;
      power_due_ns_ = now_ns + kPowerRetryNs;
      start(now_ns, SetPowerModeRequest{wanted_.power}, Purpose::power, out);
      return true;
    }
    case LinkState::configuring:
      while (setup_step_ < setup_.size() && setup_[setup_step_].outcome == Outcome::unsupported) ++setup_step_;
      if (setup_step_ < setup_.size()) {
        start_setting(now_ns, setup_step_++, out);
      } else {
        info_.state = LinkState::idle;
      }
      return true;
    case LinkState::idle:
    case LinkState::sampling:
      if (wanted_.sampling == (info_.state == LinkState::sampling) || now_ns < sampling_due_ns_) break;
      sampling_asked_ = wanted_.sampling;
      start(now_ns, SamplingRequest{sampling_asked_ ? Sampling::start : Sampling::stop}, Purpose::sampling, out);
      return true;
    case LinkState::leaving:
      ++leave_step_;
      if (leave_step_ == 1) {
        start(now_ns, SamplingRequest{Sampling::stop}, Purpose::leave, out);
      } else if (leave_step_ == 2) {
        start(now_ns, DisconnectRequest{}, Purpose::leave, out);
      } else {
        close(now_ns, out);
      }
      return true;
    default:
      break;
  }
  if (!wants_user) return retry_setting(now_ns, out);
  const ControlPayload request = std::move(requests_.front());
  requests_.pop_front();
  start(now_ns, request, Purpose::user, out);
  return true;
}

// Back to where the wanted work state is waited for; the settings are sent again then.
void DeviceLink::prepare(std::int64_t now_ns, bool is_wanted, ProtocolOutput& out) {
  if (exchange_ && (exchange_->purpose == Purpose::setup || exchange_->purpose == Purpose::sampling)) exchange_.reset();
  end_sampling(now_ns, is_wanted, out);
  info_.state = LinkState::preparing;
}

void DeviceLink::end_sampling(std::int64_t now_ns, bool is_wanted, ProtocolOutput& out) {
  if (info_.state != LinkState::sampling) return;
  if (!is_wanted) ++info_.counters.interruptions;
  tell(now_ns, SamplingChanged{false}, out);
}

Expected<void> DeviceLink::request(std::int64_t now_ns, ControlPayload request, ProtocolOutput& out) {
  const Command command = command_of(request);
  const std::string where = command_name(command) + " for " + info_.broadcast.broadcast_code;
  if (!is_command(request) || is_own_request(command)) return input_error("cannot be asked by a user", where);
  if (!can_send(request))
    return input_error("fits into no frame", where, "ask for less at once; times reach from 2000 to 2255");
  if (!is_connected() || info_.state == LinkState::identifying || info_.state == LinkState::leaving)
    return system_error("the device is not connected", where, "wait until it is");
  if (!can_do(info_.broadcast.type, info_.firmware, request))
    return input_error("the " + model_name(info_.broadcast.type) + " with firmware " + firmware_text(info_.firmware) +
                           " does not know this",
                       where);
  if (requests_.size() >= kMaxRequests)
    return system_error("too many requests wait for answers", where, "wait for those");
  requests_.push_back(std::move(request));
  advance(now_ns, out);
  return {};
}

void DeviceLink::set_sampling(std::int64_t now_ns, bool on, ProtocolOutput& out) {
  wanted_.sampling = on;
  sampling_due_ns_ = now_ns;
  advance(now_ns, out);
}

void DeviceLink::set_power(std::int64_t now_ns, PowerMode mode, ProtocolOutput& out) {
  wanted_.power = mode;
  power_due_ns_ = now_ns;
  const bool set_up = is_connected() && info_.state != LinkState::identifying && info_.state != LinkState::leaving;
  if (set_up && !is_wanted_work_state()) prepare(now_ns, true, out);
  advance(now_ns, out);
}

void DeviceLink::leave(std::int64_t now_ns, ProtocolOutput& out) {
  if (info_.state == LinkState::leaving || info_.state == LinkState::closed) return;
  if (!is_connected()) return close(now_ns, out);
  end_sampling(now_ns, true, out);
  exchange_.reset();
  requests_.clear();
  info_.state = LinkState::leaving;
  leave_step_ = 0;
  leave_end_ns_ = now_ns + kLeaveNs;
  advance(now_ns, out);
}

void DeviceLink::lose(std::int64_t now_ns, LossCause cause, ProtocolOutput& out) {
  end_sampling(now_ns, cause == LossCause::rebooting || cause == LossCause::disconnected, out);
  if (exchange_ && exchange_->purpose == Purpose::user)
    tell(now_ns, RequestEnded{exchange_->command, Outcome::lost, RawControl{}}, out);
  for (const ControlPayload& request : requests_)
    tell(now_ns, RequestEnded{command_of(request), Outcome::lost, RawControl{}}, out);
  exchange_.reset();
  requests_.clear();
  info_.state = LinkState::waiting;
  ++info_.counters.losses;
  tell(now_ns, Lost{cause}, out);
}

void DeviceLink::close(std::int64_t now_ns, ProtocolOutput& out) {
  exchange_.reset();
  info_.state = LinkState::closed;
  tell(now_ns, Closed{}, out);
}

}  // namespace rigcal::livox
