#include "apps/live_result.h"

#include <chrono>
#include <utility>

#include "apps/calibration_run.h"
#include "apps/stream_recording.h"
#include "core/pipeline/stage_clock.h"

namespace rigcal {
namespace {

// Also keeps the warnings for the result.
class KeepingReporter final : public Reporter {
 public:
  explicit KeepingReporter(Reporter& to) : to_(to) {}
  void progress(std::string_view stage, double fraction) override { to_.progress(stage, fraction); }
  void warn(std::string message) override {
    warnings_.push_back(message);
    to_.warn(std::move(message));
  }
  void debug(std::string message) override { to_.debug(std::move(message)); }
  [[nodiscard]] std::vector<std::string> take() { return std::move(warnings_); }

 private:
  Reporter& to_;
  std::vector<std::string> warnings_;
};

}  // namespace

Expected<LiveResult> finish_live(const std::string& session, const StopReading& reading, LiveCalibration& calibration,
                                 const std::string& out, const RunContext& context) {
  const auto begun = std::chrono::steady_clock::now();
  KeepingReporter reporter(context.reporter);
  const RunContext kept{reporter, context.stop};
  StageClock clock;
  StageReport& stage = clock.begin("the last stops");
  LidarRecording lidar = calibration.finish();
  const Expected<StreamSource> source = open_stream(session, {});
  if (!source) return source.error();
  Expected<Recording> recording = make_recording(*source, reading, std::move(lidar), kept);
  if (!recording) return recording.error();
  take_cameras({session, {}, {}}, *recording);
  stage.counts = {{"points", static_cast<double>(recording->points)},
                  {"stops", static_cast<double>(recording->lidar.stops.size())}};
  std::vector<StageReport> stages = clock.take();
  Expected<CalibrationResult> result = calibrate_by_default(*recording, kept);
  if (!result) return result.error();
  // The packets are in the session beside it: reading them all again for their digest would take longer than the rest.
  CalibrationRun run{std::move(stages), reporter.take(), {{"SESSION", session}, {"--calibrate", "yes"}}, {}};
  if (const auto written = write_calibration(*recording, std::move(run), out, *result); !written) {
    return written.error();
  }
  LiveResult live{std::move(*result), out, 0.0, {}};
  live.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
  return live;
}

}  // namespace rigcal
