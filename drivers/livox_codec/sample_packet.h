#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/base/bytes.h"
#include "core/base/error.h"
#include "core/records/records.h"
#include "drivers/livox_codec/status.h"

namespace rigcal::livox {

enum class TimestampType : std::uint8_t {
  since_start = 0,  ///< Free-running, from the start of the device.
  ptp = 1,
  gps = 3,       ///< PPS and UTC; microseconds on the wire.
  pps_only = 4,  ///< Since the last pulse: starts again every second.
};

enum class DataType : std::uint8_t {
  cartesian = 0,
  spherical = 1,
  cartesian_tagged = 2,
  spherical_tagged = 3,
  dual_cartesian = 4,
  dual_spherical = 5,
  imu = 6,
  triple_cartesian = 7,
  triple_spherical = 8,
};

/// What the records of a data type look like. A slot is one shot of the laser, with or without returns.
struct RecordLayout {
  std::uint16_t slots = 0;  ///< Shots of a packet (1 for the IMU).
  std::uint16_t slot_bytes = 0;
  std::uint8_t echoes = 0;  ///< Points of a slot (0 for the IMU).
  bool spherical = false;
  bool tagged = false;
};

constexpr std::size_t kSampleHeaderBytes = 18;
constexpr std::uint16_t kMaxSlots = 100;

[[nodiscard]] const RecordLayout& record_layout(DataType type);
/// Every packet is full: its size follows from its data type.
[[nodiscard]] std::size_t packet_bytes(DataType type);

struct SampleHeader {
  std::uint8_t slot = 1;      ///< 1 unless behind a Hub (1 to 9).
  std::uint8_t lidar_id = 1;  ///< Mid-100: 1 left, 2 middle, 3 right.
  std::uint32_t status = 0;   ///< See `decode_status`.
  TimestampType timestamp_type = TimestampType::since_start;
  DataType data_type = DataType::cartesian;
  /// Of the first shot, in the device's time scale: since its start, since 1970 (PTP, GPS), or since the last pulse.
  std::int64_t device_stamp_ns = 0;
};

/// A packet whose length and header have been checked. `records` points into the bytes that were parsed.
struct SamplePacket {
  SampleHeader header;
  ByteView records;
};

/// Error: wrong version, unknown data type, reserved or impossible time stamp, or a length that does not fit the data
/// type; the error's `where` is the offset of the field. Any bytes may be given.
[[nodiscard]] Expected<SamplePacket> parse_sample_packet(ByteView datagram);

/// Replaces `points` by the returns of a point packet: metres in the sensor's frame, slots without a return left out,
/// all echoes of a slot with the slot's number as `shot`. Spherical records with impossible angles are left out too.
void decode_points(const SamplePacket& packet, std::vector<Point>& points);

/// One reading of the inertial unit in the sensor's frame.
struct ImuReading {
  std::array<float, 3> gyro_rad_s{};
  std::array<float, 3> acceleration_g{};

  bool operator==(const ImuReading&) const = default;
};

/// Error: a value is not a finite number.
[[nodiscard]] Expected<ImuReading> decode_imu(const SamplePacket& packet);

/// Replaces `bytes` by a full packet. Each point goes to the slot that `shot` names, echoes in the order given, at most
/// as many as the data type has; the other slots are zeros (no return). Rounded to millimetres and 0.01 degrees; the
/// echoes of a spherical slot share the direction of the first. Tags are dropped where the data type has none.
void encode_points(const SampleHeader& header, std::span<const Point> points, std::vector<std::uint8_t>& bytes);

void encode_imu(const SampleHeader& header, const ImuReading& reading, std::vector<std::uint8_t>& bytes);

/// Writes another status, time stamp and type of time stamp over those of a packet, which must hold a whole header;
/// everything else stays as it is. A stamp of type `gps` is cut to microseconds.
void overwrite_stamp(std::uint32_t status, TimestampType type, std::int64_t device_stamp_ns,
                     std::span<std::uint8_t> packet);

}  // namespace rigcal::livox
