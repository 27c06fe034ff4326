#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "apps/ingest/lidar_ingest.h"
#include "apps/recording/datagram_file.h"
#include "core/io/ros_messages.h"

namespace rigcal {

/// A recording being read: points and inertial readings on the session clock, in the order in which they came. Files of
/// datagrams and bags are both this; what follows (stops, patches, cells) does not tell them apart.
class BatchSource {
 public:
  BatchSource() = default;
  BatchSource(const BatchSource&) = delete;
  BatchSource& operator=(const BatchSource&) = delete;
  virtual ~BatchSource() = default;

  /// Some milliseconds of work, in which the sinks are called; false at the end.
  [[nodiscard]] virtual Expected<bool> read_some() = 0;
  /// How much is read, 0 .. 1.
  [[nodiscard]] virtual double fraction() const = 0;
  [[nodiscard]] virtual IngestSummary summary() const = 0;
  /// Where and why the recording ended too soon or has a hole, one clause; empty otherwise.
  [[nodiscard]] virtual std::string truncation() const = 0;
  [[nodiscard]] virtual FileNotes notes() const { return {}; }
  /// The codes to read the recording again with, where a device said too late who it is.
  [[nodiscard]] virtual std::optional<BroadcastCodes> better_codes() const { return std::nullopt; }
};

/// An image of a camera of the rig, as its message holds it.
struct RecordedImage {
  int sensor = 0;
  std::int64_t stamp_ns = 0;  ///< Session time; when the image came, but for the jitter.
  RosType type = RosType::image;
  const RosImage& image;
};

/// Empty ones are not called.
struct BatchSinks {
  LidarIngest::PointSink points;
  LidarIngest::ImuSink imu;
  std::function<void(const RecordedImage&)> images;
};

/// Opens a file by what is in it. A rig without sensors: all is counted, nothing is handed on. Errors: missing,
/// unreadable, of no known kind.
[[nodiscard]] Expected<std::unique_ptr<BatchSource>> open_batches(const std::string& path, const Rig& rig,
                                                                  BatchSinks sinks, const BroadcastCodes& codes = {});

/// The same for datagrams from anywhere, for example live ones.
[[nodiscard]] std::unique_ptr<BatchSource> make_batches(std::unique_ptr<DatagramFile> datagrams, const Rig& rig,
                                                        BatchSinks sinks, const BroadcastCodes& codes = {});

}  // namespace rigcal
