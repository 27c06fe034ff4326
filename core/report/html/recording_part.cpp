// What was recorded: when the rig stood, what was lost, how the clocks ran.
#include <algorithm>
#include <map>

#include "core/base/seconds.h"
#include "core/base/text.h"
#include "core/base/version.h"
#include "core/report/html/parts.h"
#include "core/report/html_text.h"
#include "core/report/svg_plot.h"

namespace rigcal::html {
namespace {

constexpr int left_out_series = 6;

bool is_timed(const CalibrationResult& result) {
  return std::any_of(result.trajectory.begin(), result.trajectory.end(),
                     [](const StopPose& pose) { return pose.stop.end_ns > pose.stop.start_ns; });
}

// What a sensor has of a stop: points, or images.
struct Seen {
  std::uint64_t count = 0;
  const char* what = "points";
};

using SeenAtStops = std::map<std::string, std::map<std::size_t, Seen>>;

SeenAtStops seen_at_stops(const CalibrationResult& result) {
  SeenAtStops seen;
  for (std::size_t j = 0; j < result.trajectory.size(); ++j) {
    for (const auto& [name, points] : result.trajectory[j].points) seen[name][j] = {points, "points"};
  }
  for (const CameraEvidence& camera : result.cameras) {
    for (const UsedImage& image : camera.images) {
      Seen& here = seen[camera.name][static_cast<std::size_t>(image.stop)];
      here = {here.count + 1, "images"};
    }
  }
  return seen;
}

std::uint64_t most_of(const std::map<std::size_t, Seen>& stops) {
  std::uint64_t most = 1;
  for (const auto& [stop, seen] : stops) most = std::max(most, seen.count);
  return most;
}

std::string timeline(const CalibrationResult& result) {
  const bool timed = is_timed(result);
  const SeenAtStops seen = seen_at_stops(result);
  PlotAxis names{"", 0.0, 1.0, false, {}};
  for (const SensorResult& sensor : result.sensors) {
    if (seen.count(sensor.name) > 0) names.categories.push_back(sensor.name);
  }
  if (names.categories.empty()) return {};
  const std::int64_t zero_ns = result.trajectory.front().stop.start_ns;
  const auto seconds = [&](std::int64_t stamp_ns) { return seconds_of_ns(stamp_ns - zero_ns); };
  PlotAxis time{"seconds from the first stop on", 0.0, 1.0};
  if (timed) {
    time.high = std::max(seconds(result.trajectory.back().stop.end_ns), 1.0);
  } else {
    time = {"stop", -0.5, static_cast<double>(result.trajectory.size()) - 0.5};
  }
  SvgPlot plot(760, 80 + 28 * static_cast<int>(names.categories.size()), time, names, "When the rig stood still");
  for (std::size_t i = 0; i < names.categories.size(); ++i) {
    const std::string& name = names.categories[i];
    const auto row = static_cast<double>(i);
    const double most = static_cast<double>(most_of(seen.at(name)));
    for (const auto& [j, here] : seen.at(name)) {
      if (j >= result.trajectory.size()) continue;
      const StopPose& pose = result.trajectory[j];
      const double begin = timed ? seconds(pose.stop.start_ns) : static_cast<double>(j) - 0.42;
      const double end = timed ? seconds(pose.stop.end_ns) : static_cast<double>(j) + 0.42;
      plot.box({begin, row - 0.35}, {end, row + 0.35}, pose.is_used() ? 0 : left_out_series,
               "stop " + std::to_string(pose.stop.index) + ", " + name + ": " + std::to_string(here.count) + " " +
                   here.what + (pose.is_used() ? "" : ", left out"),
               0.25 + 0.75 * static_cast<double>(here.count) / most);
    }
  }
  plot.legend("used (stronger: saw more; none: saw nothing)", 0);
  plot.legend("left out", left_out_series);
  return figure(plot.svg(), timed ? "When the rig stood still, and who saw something then."
                                  : "Who saw something at which stop; the recording has no times.");
}

std::string ledger(const CalibrationResult& result) {
  std::vector<std::vector<std::string>> rows;
  for (const SensorResult& sensor : result.sensors) {
    const auto counters = result.packets.find(sensor.name);
    if (counters == result.packets.end()) continue;
    for (const char* stream : {"point", "imu"}) {
      const auto count = [&](const char* what) {
        const auto found = counters->second.find(std::string(stream) + "_" + what);
        return found == counters->second.end() ? std::uint64_t{0} : found->second;
      };
      const std::uint64_t expected = count("expected");
      if (expected + count("received") == 0) continue;
      const double share =
          100.0 * static_cast<double>(count("lost")) / static_cast<double>(std::max<std::uint64_t>(expected, 1));
      rows.push_back({sensor.name, stream, std::to_string(expected), std::to_string(count("received")),
                      std::to_string(count("lost")) + " (" + fixed_text(share, 3) + " %)",
                      std::to_string(count("duplicated")), std::to_string(count("out_of_order")),
                      std::to_string(count("damaged")), std::to_string(count("gaps")),
                      count("gaps") == 0 ? "–" : fixed_text(1e-3 * static_cast<double>(count("longest_gap_ms")), 3)});
    }
  }
  if (rows.empty()) return {};
  return "<h3>Packets</h3>" +
         table(
             {"sensor", "stream", "expected", "received", "lost", "twice", "out of order", "damaged", "gaps",
              "longest gap, s"},
             rows,
             "Livox packets carry no number: what was lost follows from their time stamps, up to what came before the "
             "first and after the last one.");
}

std::string clocks(const CalibrationResult& result) {
  std::vector<std::vector<std::string>> rows;
  for (const SensorResult& sensor : result.sensors) {
    for (const ClockReport& clock : result.clocks) {
      if (clock.sensor != sensor.name) continue;
      rows.push_back({clock.sensor, fixed_text(clock.drift_ppm, 2), fixed_text(clock.jitter_us, 1),
                      fixed_text(clock.max_delay_us, 1), std::to_string(clock.jumps), std::to_string(clock.strays)});
    }
  }
  if (rows.empty()) return {};
  return "<h3>Clocks</h3>" + table({"sensor", "drift, ppm", "jitter, µs", "latest packet, µs", "jumps", "stray stamps"},
                                   rows,
                                   "Each device's own clock, mapped to the clock of the session by when its "
                                   "packets came. Positive drift: it runs fast.");
}

std::string inputs(const CalibrationResult& result) {
  std::vector<std::vector<std::string>> rows;
  bool in_part = false;
  bool folders = false;
  for (const InputDigest& input : result.inputs) {
    in_part |= input.in_part;
    folders |= input.path.ends_with('/');
    rows.push_back({input.path, std::to_string(input.files), fixed_text(1e-6 * static_cast<double>(input.bytes), 3),
                    input.sha256 + (input.in_part ? " (in part)" : "")});
  }
  if (rows.empty()) return {};
  std::string remark;
  if (folders)
    remark +=
        "Of a folder: <code>find -L . -type f -print0 | LC_ALL=C sort -z | xargs -0 sha256sum | sha256sum</code> in "
        "it. ";
  if (in_part) remark += "In part: of the size, a newline, the first and the last 16 MiB of files larger than 1 GiB.";
  return "<h3>Inputs</h3>" + table({"file", "files", "MB", "SHA-256"}, rows, remark);
}

}  // namespace

std::string recording_part(const CalibrationResult& result) {
  return section("recording", "The recording", timeline(result) + ledger(result) + clocks(result));
}

std::string run_part(const CalibrationResult& result) {
  std::vector<std::vector<std::string>> rows{{"rigcal", version()}, {"compiler", __VERSION__}};
  for (const auto& [name, value] : result.settings) rows.push_back({name, value});
  return section("run", "The run", table({"", "value"}, rows) + inputs(result));
}

}  // namespace rigcal::html
