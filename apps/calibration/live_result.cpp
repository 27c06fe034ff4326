#include "apps/calibration/live_result.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "apps/calibration/calibration_run.h"
#include "apps/calibration/input_digester.h"
#include "apps/recording/stream_recording.h"
#include "core/base/keeping_reporter.h"
#include "core/base/seconds.h"
#include "core/base/text.h"
#include "core/pipeline/stage_clock.h"

namespace rigcal {
std::optional<std::string> lost_stops_warning(std::span<const StopRecord> stops, std::int64_t forgotten_until_ns) {
  std::vector<std::string> lost;
  const auto gone = std::partition_point(stops.begin(), stops.end(), [forgotten_until_ns](const StopRecord& stop) {
    return stop.stop.end_ns <= forgotten_until_ns;
  });
  if (gone != stops.begin()) {
    const std::string first = std::to_string(stops.front().stop.index);
    const std::string last = std::to_string((gone - 1)->stop.index);
    lost.push_back(first == last ? "stop " + first + " is not in the session any more"
                                 : "stops " + first + " to " + last + " are not in the session any more");
  }
  if (gone != stops.end() && gone->stop.start_ns <= forgotten_until_ns)
    lost.push_back("of stop " + std::to_string(gone->stop.index) + " the session has only the end");
  if (lost.empty()) return std::nullopt;
  return joined(lost, ", and ") + " (--keep): calibrating the session gives another result than this one";
}

Expected<LiveResult> finish_live(const std::string& session, const StopReading& reading,
                                 std::optional<std::int64_t> forgotten_until_ns, LiveCalibration& calibration,
                                 const std::string& out, const RunContext& context,
                                 const std::function<void(const CalibrationResult&, double)>& solved) {
  const auto begun = SteadyClock::now();
  const auto passed_s = [begun] { return seconds_since(begun); };
  KeepingReporter reporter(context.reporter);
  const RunContext kept{reporter, context.stop};
  StageClock clock;
  StageReport& stage = clock.begin("the last stops");
  LiveCells cells = calibration.finish();
  if (cells.left_out > 0)
    return input_error("of its " + std::to_string(reading.stops.size()) + " stops " + std::to_string(cells.left_out) +
                           " were left out while it was recorded, to bound the memory",
                       session, "solve all of them: rigcal calibrate " + session);
  const Expected<StreamSource> source = open_stream(session, {});
  if (!source) return source.error();
  Expected<Recording> recording = make_recording(*source, reading, std::move(cells.lidar), kept);
  if (!recording) return recording.error();
  if (forgotten_until_ns) {
    if (auto warning = lost_stops_warning(reading.stops, *forgotten_until_ns)) reporter.warn(std::move(*warning));
  }
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
