#include "drivers/livox_codec/sample_packet.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "drivers/livox_codec/sample_header.h"
#include "drivers/livox_codec/wire_fields.h"

namespace rigcal::livox {
namespace {

constexpr std::uint8_t packet_version = 5;
// Offsets in the header.
constexpr std::ptrdiff_t status_at = 4;
constexpr std::size_t data_type_at = 9;

// In the order of DataType.
constexpr std::array<RecordLayout, 9> layouts{{
    {100, 13, 1, false, false},
    {100, 9, 1, true, false},
    {96, 14, 1, false, true},
    {96, 10, 1, true, true},
    {48, 28, 2, false, true},
    {48, 16, 2, true, true},
    {1, 24, 0, false, false},
    {30, 42, 3, false, true},
    {30, 22, 3, true, true},
}};

Error packet_error(std::string what, std::size_t offset) {
  return input_error(std::move(what), "sample packet, offset " + std::to_string(offset));
}

}  // namespace

const RecordLayout& record_layout(DataType type) { return layouts[static_cast<std::size_t>(type)]; }

std::size_t packet_bytes(DataType type) {
  const RecordLayout& layout = record_layout(type);
  return kSampleHeaderBytes + std::size_t{layout.slots} * layout.slot_bytes;
}

Expected<SamplePacket> parse_sample_packet(ByteView datagram) {
  if (datagram.size() < kSampleHeaderBytes) return packet_error("shorter than its header", datagram.size());
  SamplePacket packet;
  SampleHeader& header = packet.header;
  ByteReader reader(datagram);
  if (reader.read<std::uint8_t>() != packet_version) return packet_error("the version is not 5", 0);
  header.slot = reader.read<std::uint8_t>();
  header.lidar_id = reader.read<std::uint8_t>();
  (void)reader.read<std::uint8_t>();  // Reserved.
  header.status = reader.read<std::uint32_t>();
  const auto timestamp_type = reader.read<std::uint8_t>();
  const auto data_type = reader.read<std::uint8_t>();
  if (data_type >= layouts.size()) return packet_error("unknown data type " + std::to_string(data_type), 9);
  header.data_type = static_cast<DataType>(data_type);
  if (datagram.size() != packet_bytes(header.data_type)) {
    return packet_error("data type " + std::to_string(data_type) + " makes " +
                            std::to_string(packet_bytes(header.data_type)) + " bytes, not " +
                            std::to_string(datagram.size()),
                        9);
  }
  if (timestamp_type > 4 || timestamp_type == 2) {
    return packet_error("unknown time stamp type " + std::to_string(timestamp_type), 8);
  }
  header.timestamp_type = static_cast<TimestampType>(timestamp_type);
  if (header.timestamp_type == TimestampType::gps) {
    const std::optional<std::int64_t> time_ns = read_utc_time(reader);
    if (!time_ns) return packet_error("the GPS time is no date", 10);
    header.device_stamp_ns = *time_ns;
  } else {
    header.device_stamp_ns = reader.read<std::int64_t>();
    if (header.device_stamp_ns < 0) return packet_error("the time stamp is out of range", 10);
  }
  packet.records = datagram.subspan(kSampleHeaderBytes);
  return packet;
}

void write_sample_header(const SampleHeader& header, std::vector<std::uint8_t>& bytes) {
  bytes.clear();
  bytes.reserve(packet_bytes(header.data_type));
  append_sample_header(header, bytes);
}

void append_sample_header(const SampleHeader& header, std::vector<std::uint8_t>& bytes) {
  ByteWriter writer(bytes);
  writer.write(packet_version);
  writer.write(header.slot);
  writer.write(header.lidar_id);
  writer.write(std::uint8_t{0});
  writer.write(header.status);
  writer.write(static_cast<std::uint8_t>(header.timestamp_type));
  writer.write(static_cast<std::uint8_t>(header.data_type));
  if (header.timestamp_type == TimestampType::gps) {
    write_utc_time(header.device_stamp_ns, writer);
  } else {
    writer.write(header.device_stamp_ns);
  }
}

void overwrite_stamp(std::uint32_t status, TimestampType type, std::int64_t device_stamp_ns,
                     std::span<std::uint8_t> packet) {
  RIGCAL_ASSERT(packet.size() >= kSampleHeaderBytes, "a packet without a header");
  SampleHeader header;
  header.status = status;
  header.timestamp_type = type;
  header.data_type = static_cast<DataType>(packet[data_type_at]);
  header.device_stamp_ns = device_stamp_ns;
  std::vector<std::uint8_t> bytes;
  bytes.reserve(kSampleHeaderBytes);
  append_sample_header(header, bytes);
  // Version, slot, unit and the reserved byte before the status are not of the stamp.
  std::copy(bytes.begin() + status_at, bytes.end(), packet.begin() + status_at);
}

Expected<ImuReading> decode_imu(const SamplePacket& packet) {
  RIGCAL_ASSERT(packet.header.data_type == DataType::imu, "a point packet read as an IMU packet");
  ByteReader reader(packet.records);
  ImuReading reading;
  for (float& value : reading.gyro_rad_s) value = reader.read<float>();
  for (float& value : reading.acceleration_g) value = reader.read<float>();
  const auto finite = [](float value) { return std::isfinite(value); };
  if (!std::all_of(reading.gyro_rad_s.begin(), reading.gyro_rad_s.end(), finite) ||
      !std::all_of(reading.acceleration_g.begin(), reading.acceleration_g.end(), finite)) {
    return packet_error("the inertial reading is not finite", kSampleHeaderBytes);
  }
  return reading;
}

void encode_imu(const SampleHeader& header, const ImuReading& reading, std::vector<std::uint8_t>& bytes) {
  RIGCAL_ASSERT(header.data_type == DataType::imu, "an IMU reading in a point packet");
  write_sample_header(header, bytes);
  ByteWriter writer(bytes);
  for (const float value : reading.gyro_rad_s) writer.write(value);
  for (const float value : reading.acceleration_g) writer.write(value);
}

}  // namespace rigcal::livox
