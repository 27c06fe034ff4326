#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "apps/recording/stop_reader.h"

namespace rigcal {

/// How a recording is read once: what its stops are found from, and what is known of its devices beforehand.
struct PassPlan {
  StopOptions options;
  BroadcastCodes codes;
};

/// The plan to begin with: the base's inertial unit where it has one, because its frame is the rig's; the points where
/// no sensor of the rig has a unit.
[[nodiscard]] PassPlan first_plan(const Rig& rig, const StopOptions& options);

/// What one reading gave.
struct StopPass {
  StopReading reading;
  /// What to read it again with, where a device said too late who it is.
  std::optional<BroadcastCodes> better_codes;
};

/// Looks over a pass's shoulder; called in the thread that reads.
class PassWatcher {
 public:
  virtual ~PassWatcher() = default;
  /// After each inertial reading and each packet of points, with its stamp.
  virtual void looked(const StopFinder& /*finder*/, std::int64_t /*stamp_ns*/) {}
  /// After the sink was told of the stop.
  virtual void found(const StopRecord& /*stop*/) {}
  /// Asked now and then; false ends the pass here.
  virtual bool goes_on(const BatchSource& /*batches*/, const StopFinder& /*finder*/) { return true; }
};

/// Opens the recording from its start.
using BatchOpener = std::function<Expected<std::unique_ptr<BatchSource>>(BatchSinks, const BroadcastCodes&)>;

/// Reads a recording from its start to its end, or as long as the watcher wants; `name` stands for it in errors.
/// Errors: an unreadable file, what the sink says, cancelled.
[[nodiscard]] Expected<StopPass> read_pass(const BatchOpener& open, const std::string& name, const PassPlan& plan,
                                           StopSink& sink, const RunContext& context, PassWatcher* watcher = nullptr);

}  // namespace rigcal
