#include "simdata/gige/virtual_camera.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/seconds.h"
#include "drivers/gige_codec/pixel_code.h"
#include "drivers/gige_codec/stream_packet.h"

namespace rigcal::sim {
namespace {

namespace bootstrap = gige::bootstrap;
using gige::Status;

constexpr std::int64_t twice_within_ns = 5'000'000'000;  // A command that comes again so soon is the same one.
constexpr double pending_from_s = 0.1;                   // Answers that take longer are said to be pending.
constexpr std::size_t most_delayed = 256;
constexpr double wanted_mean = 0.45;

gige::Ipv4 to_ip(std::uint32_t value) {
  return {static_cast<std::uint8_t>(value >> 24U), static_cast<std::uint8_t>(value >> 16U),
          static_cast<std::uint8_t>(value >> 8U), static_cast<std::uint8_t>(value)};
}

}  // namespace

std::optional<LinePulse> FrameOrder::strobe(std::uint32_t line) const {
  if (line >= kLines || !settings.strobes[line].is_on) return std::nullopt;
  const Strobe& strobe = settings.strobes[line];
  const std::int64_t rise_ns = start_ns + strobe.delay_ns;
  const std::int64_t length_ns = strobe.duration_ns > 0 ? strobe.duration_ns : settings.rules.exposure_ns;
  return LinePulse{line, rise_ns, rise_ns + length_ns, static_cast<std::int64_t>(number)};
}

FrameWish FrameOrder::wish() const {
  FrameWish wish;
  wish.number = number;
  wish.start_ns = start_ns;
  wish.pulse = pulse;
  wish.pixel_format = gige::pixel_name(settings.pixel_format);
  wish.width = settings.width;
  wish.height = settings.height;
  wish.offset_x = settings.offset_x;
  wish.offset_y = settings.offset_y;
  wish.exposure_us = settings.exposure_us;
  wish.gain_db = settings.gain_db;
  return wish;
}

VirtualCamera::VirtualCamera(const VirtualCameraOptions& options, std::uint16_t stream_port, std::int64_t now_ns)
    : options_(options), stream_port_(stream_port), registers_(options) {
  start(now_ns);
  clock_zero_ns_ = options.clock_start_ns;
}

void VirtualCamera::start(std::int64_t now_ns) {
  registers_.reset();
  registers_.memory().set(bootstrap::kStreamSourcePort, stream_port_);
  schedule_.stop();
  owner_.reset();
  is_exclusive_ = false;
  booted_ns_ = now_ns;
  clock_zero_ns_ = 0;
  reset_due_ns_.reset();
  block_ = options_.first_block;
  delayed_.clear();
  done_.reset();
}

void VirtualCamera::reboot(std::int64_t now_ns, CameraOutput& out) {
  start(now_ns + ns_of_seconds(options_.boot_s));
  dark_until_ns_ = booted_ns_;
  out.is_stream_closed = true;
}

std::uint64_t VirtualCamera::ticks(std::int64_t now_ns) const {
  const auto on_ns = static_cast<double>(now_ns - booted_ns_) * (1.0 + options_.clock_drift);
  const std::int64_t own_ns = clock_zero_ns_ + std::llround(on_ns);
  return static_cast<std::uint64_t>(std::max<std::int64_t>(own_ns, 0)) /
         (ns_per_second / CameraRegisters::kTicksPerSecond);
}

void VirtualCamera::set_stream_port(std::uint16_t port) {
  stream_port_ = port;
  registers_.memory().set(bootstrap::kStreamSourcePort, port);
}

StreamTarget VirtualCamera::stream() const {
  const RegisterMemory& memory = registers_.memory();
  StreamTarget target;
  target.to = {to_ip(memory.value(bootstrap::kStreamDestination)),
               static_cast<std::uint16_t>(memory.value(bootstrap::kStreamPort))};
  const std::uint32_t size = memory.value(bootstrap::kStreamPacketSize);
  target.packet_bytes = size & gige::kPacketSizeBits;
  target.do_not_fragment = (size & gige::kDoNotFragment) != 0;
  target.packet_delay_ns =
      std::int64_t{memory.value(bootstrap::kStreamPacketDelay)} * (ns_per_second / CameraRegisters::kTicksPerSecond);
  return target;
}

void VirtualCamera::stop_acquisition(CameraOutput& out) {
  schedule_.stop();
  registers_.set(Feature::locked, 0);
  out.is_stream_closed = true;
}

void VirtualCamera::release(CameraOutput& out) {
  owner_.reset();
  is_exclusive_ = false;
  RegisterMemory& memory = registers_.memory();
  for (const auto address : {bootstrap::kPrivilege, bootstrap::kPrimaryPort, bootstrap::kPrimaryIp,
                             bootstrap::kStreamPort, bootstrap::kStreamDestination})
    memory.set(address, 0);
  stop_acquisition(out);
}

void VirtualCamera::set_owned_by_other(bool owned, CameraOutput& out) {
  if (owned && owner_) release(out);
  is_owned_by_other_ = owned;
}

void VirtualCamera::tick(std::int64_t now_ns, CameraOutput& out) {
  if (reset_due_ns_ && now_ns >= *reset_due_ns_) reboot(*reset_due_ns_, out);
  if (now_ns < dark_until_ns_) return;
  if (now_ns >= owner_until_ns()) release(out);
  for (auto it = delayed_.begin(); it != delayed_.end();) {
    if (it->due_ns > now_ns) {
      ++it;
      continue;
    }
    out.answers.push_back(std::move(it->answer));
    it = delayed_.erase(it);
  }
  while (const auto exposure = schedule_.take(now_ns)) {
    FrameOrder order;
    order.block = block_;
    order.number = number_++;
    order.start_ns = exposure->start_ns;
    order.ticks = ticks(exposure->start_ns);
    order.pulse = exposure->pulse;
    order.settings = registers_.settings();
    block_ = gige::next_block(block_);
    if (registers_.memory().value(bootstrap::kStreamPort) != 0) out.frames.push_back(std::move(order));
    if (!schedule_.is_running()) registers_.set(Feature::locked, 0);
  }
}

std::int64_t VirtualCamera::owner_until_ns() const {
  const RegisterMemory& memory = registers_.memory();
  const bool counts = (memory.value(bootstrap::kControlConfiguration) & gige::kHeartbeatOff) == 0;
  if (!owner_ || !counts) return INT64_MAX;
  return heard_ns_ + std::int64_t{memory.value(bootstrap::kHeartbeatTimeout)} * 1'000'000;
}

std::int64_t VirtualCamera::deadline_ns() const {
  std::int64_t deadline = std::min(reset_due_ns_.value_or(INT64_MAX), owner_until_ns());
  for (const Delayed& delayed : delayed_) deadline = std::min(deadline, delayed.due_ns);
  return std::max(std::min(deadline, schedule_.deadline_ns()), dark_until_ns_);
}

void VirtualCamera::pulse(const LinePulse& pulse) { schedule_.pulse(pulse); }

void VirtualCamera::meter(std::int64_t now_ns, double mean) {
  const auto automatic = static_cast<ExposureAuto>(registers_.value(Feature::exposure_auto));
  if (automatic == ExposureAuto::off) return;
  const double factor = std::clamp(wanted_mean / std::max(mean, 1e-3), 0.5, 2.0);
  // What is near enough stays, so that it does not swing.
  if (std::abs(factor - 1.0) < 0.05) {
    if (automatic == ExposureAuto::once) registers_.set(Feature::exposure_auto, 0);
    return;
  }
  const FeatureInfo& limits = info_of(Feature::exposure_time);
  registers_.set_real(Feature::exposure_time,
                      std::clamp(factor * registers_.real(Feature::exposure_time), limits.least, 1e5));
  if (schedule_.is_running()) schedule_.set_rules(now_ns, registers_.settings().rules);
}

bool VirtualCamera::may_read(const Endpoint& from) const {
  if (is_owned_by_other_) return false;
  return !is_exclusive_ || owner_ == from;
}

void VirtualCamera::answer(std::int64_t now_ns, const Endpoint& to, std::uint16_t id, std::vector<std::uint8_t> bytes,
                           CameraOutput& out) {
  if (options_.answer_delay_s <= 0.0) {
    out.answers.push_back({to, std::move(bytes)});
    return;
  }
  if (options_.answer_delay_s >= pending_from_s) {
    const double ms = std::min(1e3 * options_.answer_delay_s, 60'000.0);
    out.answers.push_back({to, gige::encode_ack(gige::PendingAck{static_cast<std::uint16_t>(ms)}, id)});
  }
  if (delayed_.size() < most_delayed) delayed_.push_back({now_ns + answer_delay_ns(), {to, std::move(bytes)}});
}

void VirtualCamera::receive(std::int64_t now_ns, const Endpoint& from, ByteView bytes, CameraOutput& out) {
  tick(now_ns, out);
  if (is_silent(now_ns)) return;
  const auto frame = gige::parse_command(bytes);
  if (!frame) return;
  const bool is_owner = owner_ == from;
  if (is_owner) heard_ns_ = now_ns;
  if (done_ && done_->from == from && done_->id == frame->id && now_ns - done_->time_ns < twice_within_ns &&
      std::equal(bytes.begin(), bytes.end(), done_->command.begin(), done_->command.end())) {
    if (frame->wants_ack) answer(now_ns, from, frame->id, done_->ack, out);
    return;
  }
  const auto request = gige::decode_request(*frame);
  if (!request) {
    const bool known = frame->command <= static_cast<std::uint16_t>(gige::Command::write_memory) &&
                       frame->command >= static_cast<std::uint16_t>(gige::Command::discovery);
    if (frame->wants_ack)
      answer(now_ns, from, frame->id,
             gige::make_refusal(*frame, known ? Status::invalid_header : Status::not_implemented), out);
    return;
  }
  if (const auto* resend = std::get_if<gige::ResendRequest>(&*request)) {
    // Hosts ask from the port that they receive the stream on, too.
    const bool is_host = owner_ && owner_->ip == from.ip;
    const bool is_taken = options_.can_resend && is_host && resend->channel == 0;
    if (is_taken) out.resends.push_back(*resend);
    return;
  }
  std::vector<std::uint8_t> ack = serve(now_ns, from, *frame, *request, out);
  if (std::holds_alternative<gige::WriteRegistersRequest>(*request) ||
      std::holds_alternative<gige::WriteMemoryRequest>(*request))
    done_ = Done{from, frame->id, now_ns, {bytes.begin(), bytes.end()}, ack};
  if (frame->wants_ack && !ack.empty()) answer(now_ns, from, frame->id, std::move(ack), out);
}

}  // namespace rigcal::sim
