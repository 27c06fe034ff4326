#include "apps/calibration/live_result.h"

#include <optional>
#include <utility>

#include "apps/calibration/calibration_run.h"
#include "apps/calibration/input_digester.h"
#include "apps/recording/stream_recording.h"
#include "core/base/seconds.h"
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
                                 const std::string& out, const RunContext& context,
                                 const std::function<void(const CalibrationResult&, double)>& solved) {
  const auto begun = SteadyClock::now();
  const auto passed_s = [begun] { return seconds_since(begun); };
  KeepingReporter reporter(context.reporter);
  const RunContext kept{reporter, context.stop};
  StageClock clock;
  StageReport& stage = clock.begin("the last stops");
  LiveCells cells = calibration.finish();
  const Expected<StreamSource> source = open_stream(session, {});
  if (!source) return source.error();
  Expected<Recording> recording = make_recording(*source, reading, std::move(cells.lidar), kept);
  if (!recording) return recording.error();
  take_cameras({session, {}, {}}, *recording, cells.images);
  stage.counts = {{"points", static_cast<double>(recording->points)},
                  {"stops", static_cast<double>(recording->lidar.stops.size())}};
  std::vector<StageReport> stages = clock.take();
  double solved_s = 0.0;
  std::optional<InputDigester> digester;  // Reads all packets again: while pictures are made, not before.
  Expected<CalibrationResult> result = calibrate_by_default(*recording, kept, [&](const CalibrationResult& numbers) {
    solved_s = passed_s();
    digester.emplace(std::vector<std::string>{session});
    if (solved) solved(numbers, solved_s);
  });
  if (!result) return result.error();
  CalibrationRun run{
      std::move(stages), reporter.take(), {{"SESSION", session}, {"--calibrate", "yes"}}, digester->take()};
  if (const auto written = write_calibration(*recording, std::move(run), out, *result); !written) {
    return written.error();
  }
  return LiveResult{std::move(*result), out, solved_s, passed_s(), {}};
}

}  // namespace rigcal
