// What a host's commands read and change.
#include <algorithm>
#include <utility>

#include "core/base/network_order.h"
#include "core/base/seconds.h"
#include "simdata/gige/camera_description.h"
#include "simdata/gige/virtual_camera.h"

namespace rigcal::sim {
namespace {

namespace bootstrap = gige::bootstrap;
using Access = RegisterMemory::Access;
using gige::Status;

constexpr std::int64_t shortest_reset_ns = 10'000'000;  // The command is answered before.
constexpr std::int64_t tick_ns = ns_per_second / CameraRegisters::kTicksPerSecond;

std::uint32_t to_word(const gige::Ipv4& ip) {
  return std::uint32_t{ip[0]} << 24U | std::uint32_t{ip[1]} << 16U | std::uint32_t{ip[2]} << 8U | ip[3];
}

}  // namespace

std::vector<std::uint8_t> VirtualCamera::serve(std::int64_t now_ns, const Endpoint& from,
                                               const gige::CommandFrame& frame, const gige::Request& request,
                                               CameraOutput& out) {
  if (std::holds_alternative<gige::DiscoveryRequest>(request)) {
    const auto identity = gige::decode_identity(registers_.memory().view(0, gige::DeviceIdentity::kBytes));
    return gige::encode_ack(*identity, frame.id);
  }
  if (const auto* force = std::get_if<gige::ForceIpRequest>(&request)) {
    if (force->mac != options_.identity.mac) return {};
    if (owner_ || is_owned_by_other_) return gige::make_refusal(frame, Status::access_denied);
    if (to_word(force->ip) == 0) return {};  // Find an address anew: it has found this one again.
    options_.identity.ip = force->ip;
    out.new_address = force->ip;
    RegisterMemory& memory = registers_.memory();
    memory.set(bootstrap::kIp, to_word(force->ip));
    memory.set(bootstrap::kMask, to_word(force->mask));
    memory.set(bootstrap::kGateway, to_word(force->gateway));
    return gige::encode_ack(gige::ForceIpAck{}, frame.id);
  }
  registers_.update_computed(seconds_of_ns(now_ns - booted_ns_));
  if (const auto* read = std::get_if<gige::ReadRegistersRequest>(&request)) return read_registers(from, frame, *read);
  if (const auto* read = std::get_if<gige::ReadMemoryRequest>(&request)) return read_memory(from, frame, *read);
  if (const auto* write = std::get_if<gige::WriteRegistersRequest>(&request))
    return write_registers(now_ns, from, frame, *write, out);
  return write_memory(now_ns, from, frame, std::get<gige::WriteMemoryRequest>(request), out);
}

std::vector<std::uint8_t> VirtualCamera::read_registers(const Endpoint& from, const gige::CommandFrame& frame,
                                                        const gige::ReadRegistersRequest& request) const {
  const bool asks_who = request.addresses == std::vector{bootstrap::kPrivilege};
  if (!may_read(from) && !asks_who) return gige::make_refusal(frame, Status::access_denied);
  gige::ReadRegistersAck ack;
  for (const std::uint32_t address : request.addresses) {
    const Status status = registers_.memory().check(address, 4, Access::read);
    if (status != Status::success) return gige::encode_ack(ack, frame.id, status);
    ack.values.push_back(registers_.memory().value(address));
  }
  if (asks_who && is_owned_by_other_) ack.values = {gige::kExclusive};
  return gige::encode_ack(ack, frame.id);
}

std::vector<std::uint8_t> VirtualCamera::read_memory(const Endpoint& from, const gige::CommandFrame& frame,
                                                     const gige::ReadMemoryRequest& request) const {
  if (!may_read(from)) return gige::make_refusal(frame, Status::access_denied);
  if (request.count == 0 || request.count > gige::kMaxMemoryBytes)
    return gige::make_refusal(frame, Status::invalid_parameter);
  const Status status = registers_.memory().check(request.address, request.count, Access::read);
  if (status != Status::success) return gige::make_refusal(frame, status);
  const ByteView bytes = registers_.memory().view(request.address, request.count);
  return gige::encode_ack(gige::ReadMemoryAck{request.address, {bytes.begin(), bytes.end()}}, frame.id);
}

std::vector<std::uint8_t> VirtualCamera::write_registers(std::int64_t now_ns, const Endpoint& from,
                                                         const gige::CommandFrame& frame,
                                                         const gige::WriteRegistersRequest& request,
                                                         CameraOutput& out) {
  gige::WriteRegistersAck ack;
  for (const gige::RegisterWrite& write : request.writes) {
    const Status status = write_word(now_ns, from, write.address, write.value, out);
    if (status != Status::success) return gige::encode_ack(ack, frame.id, status);
    ++ack.written;
  }
  return gige::encode_ack(ack, frame.id);
}

std::vector<std::uint8_t> VirtualCamera::write_memory(std::int64_t now_ns, const Endpoint& from,
                                                      const gige::CommandFrame& frame,
                                                      const gige::WriteMemoryRequest& request, CameraOutput& out) {
  gige::WriteMemoryAck ack;
  Status status = registers_.memory().check(request.address, request.bytes.size(), Access::write);
  ByteReader reader(request.bytes);
  while (status == Status::success && reader.left() > 0) {
    const std::uint32_t address = request.address + ack.written;
    status = write_word(now_ns, from, address, read_network<std::uint32_t>(reader), out);
    if (status == Status::success) ack.written += 4;
  }
  return gige::encode_ack(ack, frame.id, status);
}

Status VirtualCamera::write_word(std::int64_t now_ns, const Endpoint& from, std::uint32_t address, std::uint32_t value,
                                 CameraOutput& out) {
  RegisterMemory& memory = registers_.memory();
  if (const Status status = memory.check(address, 4, Access::write); status != Status::success) return status;
  if (address == bootstrap::kPrivilege) {
    const Status status = write_privilege(from, value, out);
    if (owner_ == from) heard_ns_ = now_ns;
    return status;
  }
  if (!may_write(from)) return Status::access_denied;
  if (const auto place = CameraRegisters::feature_at(address)) {
    if (const Status status = registers_.write(*place, value, is_acquiring()); status != Status::success) return status;
    if (info_of(place->feature).kind == FeatureInfo::Kind::command) return do_command(now_ns, place->feature);
    if (is_acquiring()) schedule_.set_rules(now_ns, registers_.settings().rules);
    return Status::success;
  }
  switch (address) {
    case bootstrap::kHeartbeatTimeout:
      value = std::clamp(value, kShortestHeartbeatMs, kLongestHeartbeatMs);
      break;
    case bootstrap::kTimestampControl:
      control_timestamp(now_ns, value);
      return Status::success;
    case bootstrap::kControlConfiguration:
      value &= gige::kHeartbeatOff | gige::kExtendedStatus;
      break;
    case bootstrap::kStreamPort:
      value &= 0xFFFFU;
      if (value == 0) out.is_stream_closed = true;
      break;
    case bootstrap::kStreamPacketSize:
      return write_packet_size(value, out);
    case bootstrap::kStreamPacketDelay:
      if (value > kLongestPacketDelay) return Status::invalid_parameter;
      break;
    default:
      break;
  }
  memory.set(address, value);
  return Status::success;
}

Status VirtualCamera::write_privilege(const Endpoint& from, std::uint32_t value, CameraOutput& out) {
  if (is_owned_by_other_ || (owner_ && owner_ != from)) return Status::access_denied;
  if ((value & (gige::kControl | gige::kExclusive)) == 0) {
    if (owner_) release(out);
    return Status::success;
  }
  owner_ = from;
  is_exclusive_ = (value & gige::kExclusive) != 0;
  RegisterMemory& memory = registers_.memory();
  memory.set(bootstrap::kPrivilege, value & (gige::kControl | gige::kExclusive));
  memory.set(bootstrap::kPrimaryPort, from.port);
  memory.set(bootstrap::kPrimaryIp, to_word(from.ip));
  return Status::success;
}

Status VirtualCamera::write_packet_size(std::uint32_t value, CameraOutput& out) {
  RegisterMemory& memory = registers_.memory();
  const std::uint32_t kept = value & (gige::kPacketSizeBits | gige::kDoNotFragment);
  const std::uint32_t size = value & gige::kPacketSizeBits;
  if (size < kSmallestPacket || size > kLargestPacket) return Status::invalid_parameter;
  if (is_acquiring() && size != (memory.value(bootstrap::kStreamPacketSize) & gige::kPacketSizeBits))
    return Status::write_protected;
  memory.set(bootstrap::kStreamPacketSize,
             kept - size + (size - kSmallestPacket) / kPacketStep * kPacketStep + kSmallestPacket);
  if ((value & gige::kFireTestPacket) != 0 && memory.value(bootstrap::kStreamPort) != 0) out.test_packet = stream();
  return Status::success;
}

Status VirtualCamera::do_command(std::int64_t now_ns, Feature feature) {
  switch (feature) {
    case Feature::acquisition_start: {
      const CameraSettings settings = registers_.settings();
      schedule_.start(now_ns, settings.rules, settings.frames);
      registers_.set(Feature::locked, 1);
      block_ = options_.first_block;
      number_ = 0;
      break;
    }
    case Feature::acquisition_stop:
      schedule_.stop();
      registers_.set(Feature::locked, 0);
      break;
    case Feature::trigger_software:
      schedule_.software_trigger(now_ns);
      break;
    case Feature::user_set_load:
      registers_.load_user_set(registers_.value(Feature::user_set_selector));
      break;
    case Feature::user_set_save:
      return registers_.save_user_set();
    default:
      // It still answers this one.
      reset_due_ns_ = now_ns + std::max(answer_delay_ns(), shortest_reset_ns);
      break;
  }
  return Status::success;
}

void VirtualCamera::control_timestamp(std::int64_t now_ns, std::uint32_t value) {
  if ((value & gige::kTimestampLatch) != 0) {
    const std::uint64_t latched = ticks(now_ns);
    registers_.memory().set(bootstrap::kTimestampHigh, static_cast<std::uint32_t>(latched >> 32U));
    registers_.memory().set(bootstrap::kTimestampLow, static_cast<std::uint32_t>(latched));
  }
  if ((value & gige::kTimestampReset) != 0) clock_zero_ns_ -= static_cast<std::int64_t>(ticks(now_ns)) * tick_ns;
}

}  // namespace rigcal::sim
