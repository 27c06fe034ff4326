#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>

#include "core/base/bytes.h"
#include "core/base/error.h"

namespace rigcal {

/// Who sent what: a topic may have several senders.
struct BagConnection {
  std::string topic;  ///< Printable ASCII.
  std::string type;   ///< For example "sensor_msgs/Imu".
  std::string md5;    ///< Of the type's layout.
};

/// One message as its sender packed it.
struct BagMessage {
  const BagConnection* connection = nullptr;
  std::int64_t stamp_ns = 0;  ///< When it was recorded.
  ByteView bytes;             ///< Lives until the next message is asked for.
};

/// Streams a ROS 1 bag (format 2.0; chunks uncompressed, bz2 or lz4), chunk by chunk: only those that overlap in time
/// are in memory. With the index messages come in the order of their record time, as rosbag plays them; a bag without
/// one (cut short, or still "active") is read in the order of the file. No ROS is needed. Not thread-safe.
class BagReader {
 public:
  /// Errors (kind input): missing, no bag, another format version, encrypted, cut before its first chunk.
  [[nodiscard]] static Expected<BagReader> open(const std::string& path);

  BagReader(BagReader&&) noexcept;
  BagReader& operator=(BagReader&&) noexcept;
  BagReader(const BagReader&) = delete;
  BagReader& operator=(const BagReader&) = delete;
  ~BagReader();

  /// The next message; false at the end. Chunks that are cut or damaged are left out: ask `truncation()`. Errors:
  /// too many chunks overlap in time to hold them all; `read_failure`.
  [[nodiscard]] Expected<bool> next(BagMessage& message);

  /// By the number that the bag gives them. With an index all are known from the start, otherwise as they come.
  [[nodiscard]] const std::map<std::uint32_t, BagConnection>& connections() const;
  [[nodiscard]] bool indexed() const;
  /// What was left out and why, one clause for a warning; empty where all was read.
  [[nodiscard]] std::string truncation() const;
  /// How much of the file is read, 0 .. 1.
  [[nodiscard]] double fraction() const;

 private:
  struct State;
  explicit BagReader(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace rigcal
