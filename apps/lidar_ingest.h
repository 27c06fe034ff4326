#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "apps/lidar_identity.h"
#include "core/base/error.h"
#include "core/clocks/device_clock.h"
#include "core/clocks/stream_ledger.h"
#include "core/records/records.h"
#include "core/rig/rig.h"
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

struct IngestSummary {
  std::vector<DeviceIngest> devices;  ///< Those that said anything, in the order of their addresses.
  std::uint64_t datagrams = 0;
  std::uint64_t control_frames = 0;
  std::uint64_t not_livox = 0;
  std::vector<std::string> warnings;
  std::optional<Error> unfit;  ///< What keeps it from being used with this rig, if read with the codes it holds.

  /// The device that is this sensor of the rig (the one with most packets, should there be two), or null.
  [[nodiscard]] const DeviceIngest* of_sensor(int sensor) const;
};

/// The way from datagrams to records: which device, which sensor, bytes to points, device time to session time. Used
/// alike by dumps, sessions and live sensors.
///
/// A device is known by its source address; a broadcast that names another code than the rig file has for this address
/// wins. In a recording a broadcast may follow the points it is about: give all datagrams to `learn` first where that
/// costs nothing, or ask `learned_too_late` at the end and read again with the codes.
class LidarIngest {
 public:
  /// The batch may be changed and its points swapped out; it is used again for the next packet.
  using PointSink = std::function<void(PointBatch&)>;
  using ImuSink = std::function<void(const ImuSample&)>;

  /// Empty sinks: only count. A rig without sensors: every device is listed, none is used.
  LidarIngest(const Rig& rig, PointSink points, ImuSink imu, const BroadcastCodes& codes = {});
  ~LidarIngest();
  LidarIngest(const LidarIngest&) = delete;
  LidarIngest& operator=(const LidarIngest&) = delete;
  LidarIngest(LidarIngest&&) noexcept;
  LidarIngest& operator=(LidarIngest&&) noexcept;

  /// Looks for broadcasts only; nothing is counted.
  void learn(const Datagram& datagram);
  /// Sinks are called from in here, in the order of the datagrams. Packets that come late are passed on late;
  /// duplicates and packets with senseless stamps are not.
  void add(const Datagram& datagram);

  [[nodiscard]] BroadcastCodes codes() const;
  /// A device was named after packets from it had gone to another sensor, or to none.
  [[nodiscard]] bool learned_too_late() const;

  [[nodiscard]] IngestSummary summary() const;
  /// The summary, or what keeps it from being used: no Livox packet at all, a LiDAR of the rig without points, or
  /// `learned_too_late`.
  [[nodiscard]] Expected<IngestSummary> finish() const;

 private:
  class Devices;
  std::unique_ptr<Devices> devices_;
};

}  // namespace rigcal
