#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "apps/ingest/lidar_identity.h"
#include "core/base/error.h"
#include "core/clocks/device_clock.h"
#include "core/clocks/stream_ledger.h"
#include "core/io/intensity_range.h"
#include "drivers/livox_codec/discovery.h"

namespace rigcal {

/// What came from one address.
struct DeviceIngest {
  IpAddress ip{};
  int sensor = -1;                        ///< Index in the rig; -1: none of its sensors.
  std::string broadcast_code;             ///< As the device told it; empty where it told none.
  std::optional<livox::DeviceType> type;  ///< The same.
  std::uint64_t packets = 0;              ///< Sample packets.
  std::uint64_t malformed = 0;            ///< Datagrams from this address that are no Livox packet.
  std::uint32_t worst_status = 0;         ///< The status word with the worst system level.
  std::uint64_t shots = 0;
  std::uint64_t points = 0;  ///< Given on; the four below are what was left out.
  std::uint64_t noise = 0;   ///< The sensor's tag says so, with high or moderate confidence.
  std::uint64_t out_of_range = 0;
  std::uint64_t repeated = 0;        ///< An echo that says the same as the one before it of its shot.
  std::uint64_t unused_packets = 0;  ///< Duplicates, and packets whose stamp or reading makes no sense.
  std::uint64_t imu_samples = 0;
  /// Control frames that it sent or was sent, by name (`livox::frame_name`).
  std::map<std::string, std::uint64_t> control_frames;
  std::int64_t first_ns = 0;  ///< Session time of the first and the last packet.
  std::int64_t last_ns = 0;
  ClockFigures clock;
  StreamBook point_stream;
  StreamBook imu_stream;
};

/// What came on one topic of a bag.
struct TopicIngest {
  std::string topic;
  std::string type;  ///< Of the messages, for example "sensor_msgs/Imu".
  int sensor = -1;   ///< Index in the rig; -1: none of its sensors.
  std::uint64_t messages = 0;
  std::uint64_t lost = 0;       ///< Numbers that are missing among those of one sender's messages.
  std::uint64_t malformed = 0;  ///< Messages that could not be read.
  std::string first_fault;      ///< What was wrong with the first of them.
  std::uint64_t points = 0;     ///< Given on; the three below are what was left out.
  std::uint64_t noise = 0;
  std::uint64_t out_of_range = 0;
  std::uint64_t not_finite = 0;
  IntensityRange intensity;   ///< As the messages have it.
  std::uint64_t untimed = 0;  ///< Messages whose points have no times.
  std::uint64_t imu_samples = 0;
  std::int64_t first_ns = 0;  ///< Record time of the first and the last message.
  std::int64_t last_ns = 0;
  ClockFigures clock;  ///< Of the senders' stamps; nothing for topics that are only counted.
};

/// What a recording held: `devices` where it was datagrams, `topics` where it was a bag.
struct IngestSummary {
  std::vector<DeviceIngest> devices;  ///< Those that said anything, in the order of their addresses.
  std::vector<TopicIngest> topics;    ///< In the order of their names.
  std::uint64_t datagrams = 0;
  std::uint64_t control_frames = 0;
  std::uint64_t not_livox = 0;
  std::vector<std::string> warnings;
  std::optional<Error> unfit;  ///< What keeps it from being used with this rig, if read with the codes it holds.

  /// The device that is this sensor of the rig (the one with most packets, should there be two), or null.
  [[nodiscard]] const DeviceIngest* of_sensor(int sensor) const;
};

}  // namespace rigcal
