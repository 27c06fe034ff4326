#include "simdata/usb3/usb3_camera.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "drivers/gige_codec/ack.h"
#include "drivers/gige_codec/command.h"
#include "simdata/usb3/stream_packet.h"

namespace rigcal::sim::usb3 {
namespace {

namespace bootstrap = gige::bootstrap;
using gige::Status;

constexpr std::uint32_t description_address = 0x10000;  // Of the virtual camera.
constexpr std::uint32_t stream_port = 1;                // Any: that it sends at all.
constexpr std::uint32_t super_speed = 8;
constexpr std::uint32_t response_ms = 1000;
const Endpoint host{{127, 0, 0, 1}, 1};  // The only one there is, for the virtual camera.

VirtualCameraOptions on_usb(VirtualCameraOptions options) {
  options.transport = Transport::usb3;
  return options;
}

}  // namespace

Usb3Camera::Usb3Camera(VirtualCameraOptions options, std::int64_t now_ns)
    : camera_(on_usb(options), 0, now_ns), tables_(table::kEnd) {
  define_tables(on_usb(std::move(options)));
  take_control(now_ns);
}

template <class T>
void Usb3Camera::set(std::uint32_t address, T value) {
  std::memcpy(tables_.data() + address, &value, sizeof value);
}

void Usb3Camera::define_tables(const VirtualCameraOptions& options) {
  const gige::DeviceIdentity& identity = options.identity;
  const std::pair<std::uint32_t, const std::string*> names[] = {{usb3_names::kManufacturer, &identity.manufacturer},
                                                                {usb3_names::kModel, &identity.model},
                                                                {usb3_names::kFamily, &identity.model},
                                                                {usb3_names::kVersion, &identity.device_version},
                                                                {usb3_names::kInformation, &identity.information},
                                                                {usb3_names::kSerial, &identity.serial},
                                                                {usb3_names::kUser, &identity.user_name}};
  for (const auto& [address, name] : names)
    std::copy_n(name->begin(), std::min<std::size_t>(name->size(), usb3_names::kBytes - 1), tables_.begin() + address);
  set(table::kGencpVersion, std::uint32_t{0x0001'0001});
  set(table::kCapability, std::uint64_t{0x2101});  // A user's name, a family, a timestamp.
  set(table::kResponseTime, response_ms);
  set(table::kManifestAddress, std::uint64_t{table::kManifest});
  set(table::kSecondAddress, std::uint64_t{table::kSecond});
  set(table::kTimestampIncrement, std::uint64_t{1'000'000'000 / CameraRegisters::kTicksPerSecond});
  set(table::kManifest, std::uint64_t{1});
  set(table::kManifest + 8, std::uint32_t{0x0100'0000});   // Version 1.0.0 of the file.
  set(table::kManifest + 12, std::uint32_t{0x0101'0000});  // Schema 1.1, not packed.
  set(table::kManifest + 16, std::uint64_t{description_address});
  const std::string description =
      describe_camera(options.pixel_formats, Transport::usb3, options.least_trigger_delay_us);
  set(table::kManifest + 24, std::uint64_t{description.size()});
  set(table::kSecond, std::uint32_t{0x0001'0000});
  set(table::kSecond + 4, std::uint64_t{1});  // It has a table of streams.
  set(table::kMaxCommand, static_cast<std::uint32_t>(kMaxControlBytes));
  set(table::kMaxAnswer, static_cast<std::uint32_t>(kMaxControlBytes));
  set(table::kStreams, std::uint32_t{1});
  set(table::kStreamAddress, std::uint64_t{table::kStream});
  set(table::kStreamLength, std::uint32_t{table::kEnd - table::kStream});
  set(table::kSpeed, super_speed);
  set(table::kLeaderBytesNeeded, static_cast<std::uint32_t>(kLeaderBytes));
  set(table::kTrailerBytesNeeded, static_cast<std::uint32_t>(kTrailerBytes));
}

void Usb3Camera::take_control(std::int64_t now_ns) {
  Status status{};
  static_cast<void>(ask(now_ns,
                        gige::WriteRegistersRequest{{{bootstrap::kPrivilege, gige::kControl},
                                                     {bootstrap::kControlConfiguration, gige::kHeartbeatOff},
                                                     {bootstrap::kStreamPort, stream_port}}},
                        status));
}

std::vector<std::uint8_t> Usb3Camera::ask(std::int64_t now_ns, const gige::Request& request, Status& status) {
  id_ = static_cast<std::uint16_t>(id_ == UINT16_MAX ? 1 : id_ + 1);
  CameraOutput out;
  camera_.receive(now_ns, host, gige::encode_request(request, id_), out);
  for (FrameOrder& frame : out.frames) exposed_.push_back(std::move(frame));
  status = Status::busy;  // While it restarts, it says nothing.
  if (out.answers.empty()) return {};
  const auto ack = gige::parse_ack(out.answers.back().bytes);
  if (!ack) return {};
  status = ack->status;
  if (status != Status::success) return {};
  const auto decoded = gige::decode_ack(*ack);
  const auto* memory = decoded ? std::get_if<gige::ReadMemoryAck>(&*decoded) : nullptr;
  return memory != nullptr ? memory->bytes : std::vector<std::uint8_t>();
}

void Usb3Camera::tick(std::int64_t now_ns, std::vector<FrameOrder>& frames) {
  CameraOutput out;
  camera_.tick(now_ns, out);
  if (!camera_.owner() && !camera_.is_silent(now_ns)) take_control(now_ns);
  for (FrameOrder& frame : exposed_) out.frames.push_back(std::move(frame));
  exposed_.clear();
  if (!may_send_) return;
  for (FrameOrder& frame : out.frames) frames.push_back(std::move(frame));
}

void Usb3Camera::detach(std::int64_t now_ns) {
  may_send_ = false;
  set(table::kStreamControl, std::uint32_t{0});
  const std::uint8_t one[] = {0, 0, 0, 1};
  static_cast<void>(write_feature(now_ns, address_of(Feature::acquisition_stop), one));
}

std::vector<std::uint8_t> Usb3Camera::receive(std::int64_t now_ns, ByteView packet) {
  const auto command = parse_control(packet);
  if (!command) return {};
  std::vector<std::uint8_t> answer;
  Status status = Status::not_implemented;
  if (command->kind == ControlCommand::Kind::read) {
    std::vector<std::uint8_t> bytes;
    status = read(now_ns, command->address, command->count, bytes);
    answer = encode_read_answer(command->id, bytes);
  } else if (command->kind == ControlCommand::Kind::write) {
    status = write(now_ns, command->address, command->bytes);
    answer = encode_write_answer(command->id, static_cast<std::uint16_t>(command->bytes.size()));
  }
  if (!command->wants_answer) return {};
  return status == Status::success ? answer : encode_refusal(*command, status);
}

Status Usb3Camera::read(std::int64_t now_ns, std::uint64_t address, std::size_t count,
                        std::vector<std::uint8_t>& bytes) {
  if (count > kMaxControlBytes - kControlHeaderBytes) return Status::invalid_parameter;
  if (address < tables_.size()) {
    if (count > tables_.size() - address) return Status::invalid_address;
    set(table::kPayloadBytes, static_cast<std::uint64_t>(camera_.settings().payload_bytes));
    const auto first = tables_.begin() + static_cast<std::ptrdiff_t>(address);
    bytes.assign(first, first + static_cast<std::ptrdiff_t>(count));
    return Status::success;
  }
  if (address < kFirstFeatureAddress || address > UINT32_MAX - kMaxControlBytes) return Status::invalid_address;
  // The virtual camera gives whole words, and so many at a time.
  const std::uint64_t skipped = address % 4;
  std::uint64_t next = address - skipped;
  const std::uint64_t end = (address + count + 3) / 4 * 4;
  while (next < end) {
    const std::uint64_t size = std::min<std::uint64_t>(end - next, gige::kMaxMemoryBytes);
    Status status{};
    const auto part = ask(
        now_ns, gige::ReadMemoryRequest{static_cast<std::uint32_t>(next), static_cast<std::uint16_t>(size)}, status);
    if (status != Status::success) return status;
    bytes.insert(bytes.end(), part.begin(), part.end());
    next += size;
  }
  bytes.erase(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(skipped));
  bytes.resize(count);
  return Status::success;
}

Status Usb3Camera::write(std::int64_t now_ns, std::uint64_t address, ByteView bytes) {
  if (address < tables_.size()) {
    if (bytes.size() > tables_.size() - address) return Status::invalid_address;
    return write_table(now_ns, static_cast<std::uint32_t>(address), bytes);
  }
  if (address < kFirstFeatureAddress || address > UINT32_MAX) return Status::invalid_address;
  return write_feature(now_ns, static_cast<std::uint32_t>(address), bytes);
}

Status Usb3Camera::write_table(std::int64_t now_ns, std::uint32_t address, ByteView bytes) {
  const bool is_user_name =
      address >= usb3_names::kUser && address + bytes.size() <= usb3_names::kUser + usb3_names::kBytes;
  const bool is_host_setting = address >= table::kMaxLeader;
  if (is_user_name || is_host_setting) {
    std::copy(bytes.begin(), bytes.end(), tables_.begin() + address);
    return Status::success;
  }
  if (bytes.size() != 4) return Status::write_protected;
  const auto value = ByteReader(bytes).read<std::uint32_t>();
  if (address == table::kStreamControl) {
    set(address, value & 1U);
    may_send_ = (value & 1U) != 0;
    return Status::success;
  }
  if (address == table::kTimestampLatch) {
    set(table::kTimestamp, camera_.ticks(now_ns) * (1'000'000'000U / CameraRegisters::kTicksPerSecond));
    return Status::success;
  }
  return Status::write_protected;
}

Status Usb3Camera::write_feature(std::int64_t now_ns, std::uint32_t address, ByteView bytes) {
  const auto place = CameraRegisters::feature_at(address);
  if (place && place->feature == Feature::chunk_mode) return Status::access_denied;
  if (bytes.empty() || bytes.size() % 4 != 0 || bytes.size() > gige::kMaxMemoryBytes) return Status::invalid_parameter;
  Status status{};
  static_cast<void>(
      ask(now_ns, gige::WriteMemoryRequest{address, std::vector<std::uint8_t>(bytes.begin(), bytes.end())}, status));
  return status;
}

}  // namespace rigcal::sim::usb3
