#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "apps/ingest/ingest_summary.h"
#include "apps/ingest/lidar_identity.h"
#include "core/records/records.h"
#include "core/rig/rig.h"

namespace rigcal {

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

  /// Empty sinks: only count. Of devices that no sensor of the rig is, points and readings are counted and go nowhere.
  LidarIngest(const Rig& rig, PointSink points, ImuSink imu, const BroadcastCodes& codes = {});
  /// Keeps the books by the packets' headers alone, at a tenth of the cost: no points, no inertial readings.
  [[nodiscard]] static LidarIngest of_headers(const Rig& rig);
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
