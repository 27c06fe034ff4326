#include "apps/stop_reader.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>

#include "core/io/session_folder.h"

namespace rigcal {
namespace {

bool has_imu(const Sensor& sensor) {
  if (!sensor.is_lidar() || sensor.lidar->imu == false) return false;
  if (!sensor.lidar->imu_topic.empty()) return true;
  const LidarModel model = sensor.lidar->model;
  return model == LidarModel::livox_avia || model == LidarModel::livox_horizon || model == LidarModel::livox_tele15;
}

/// Notes the stops on their way to the sink.
class NotingSink final : public PatchSink {
 public:
  NotingSink(PatchSink& sink, std::vector<StopRecord>& stops) : sink_(sink), stops_(stops) {}
  void points(int sensor, int stop, std::span<const Point> points) override { sink_.points(sensor, stop, points); }
  void timed_points(int sensor, int stop, const ShotTimes& times, std::span<const Point> part) override {
    sink_.timed_points(sensor, stop, times, part);
  }
  void stop_done(const StopRecord& stop) override {
    stops_.push_back(stop);
    sink_.stop_done(stop);
  }

 private:
  PatchSink& sink_;
  std::vector<StopRecord>& stops_;
};

struct Pass {
  StopReading summary;
  std::optional<BroadcastCodes> better_codes;
};

Expected<Pass> read_once(const StreamSource& source, const StopOptions& options, const BroadcastCodes& codes,
                         StopSink& sink, const RunContext& context) {
  Pass pass;
  if (const Expected<void> ready = sink.restart(); !ready) return ready.error();
  NotingSink noting(sink, pass.summary.stops);
  StopFinder finder(options, noting);
  const BatchSinks sinks{[&](PointBatch& batch) { finder.add_points(batch); },
                         [&](const ImuSample& sample) { finder.add_imu(sample); },
                         [&](const RecordedImage& image) { sink.image(image); }};
  const Expected<std::unique_ptr<BatchSource>> batches = open_batches(source.file, source.rig, sinks, codes);
  if (!batches) return batches.error();
  while (true) {
    const Expected<bool> more = (*batches)->read_some();
    if (!more) return more.error();
    if (!*more) break;
    if (const Expected<void> status = sink.status(); !status) return status.error();
    if (context.cancelled()) return Error{ErrorKind::cancelled, "stopped", source.path, {}};
    context.reporter.progress("reading", (*batches)->fraction());
  }
  finder.flush();
  if (const Expected<void> status = sink.status(); !status) return status.error();
  pass.summary.ingest = (*batches)->summary();
  pass.summary.still = finder.figures();
  pass.summary.points = finder.point_counts();
  pass.summary.truncation = (*batches)->truncation();
  pass.summary.notes = (*batches)->notes();
  pass.better_codes = (*batches)->better_codes();
  return pass;
}

}  // namespace

Expected<StreamSource> open_stream(const std::string& path, const std::string& rig_path) {
  StreamSource source;
  source.path = path;
  source.file = path;
  source.rig_path = rig_path;
  std::error_code error;
  if (std::filesystem::is_directory(path, error)) {
    Expected<SessionFolder> session = open_session(path);
    if (!session) return session.error();
    if (session->packets.empty()) {
      return input_error("holds no packets", path, "its patches can be used as they are");
    }
    source.file = session->packets;
    source.complete = session->record.has_value() && session->record->end_ns.has_value();
    source.rig = std::move(session->rig);
    if (rig_path.empty()) {
      source.rig_path = (std::filesystem::path(path) / "rig.yaml").string();
      return source;
    }
  }
  if (rig_path.empty()) return input_error("a recording needs the rig that made it", path, "add --rig RIG");
  Expected<Rig> rig = load_rig(rig_path);
  if (!rig) return rig.error();
  source.rig = std::move(*rig);
  return source;
}

Expected<StopReading> read_stops(const StreamSource& source, const StopOptions& options, StopSink& sink,
                                 const RunContext& context) {
  StopOptions chosen = options;
  // The base's unit, because its frame is the rig's.
  const bool has_base = !source.rig.sensors.empty();  // not so where a dump is only looked at
  if (chosen.imu_sensor < 0 && has_base && has_imu(source.rig.base_sensor())) chosen.imu_sensor = source.rig.base;
  Expected<Pass> pass = read_once(source, chosen, {}, sink, context);
  if (!pass) return pass.error();
  const bool other_unit =
      options.imu_sensor < 0 && pass->summary.still.imu_samples == 0 && pass->summary.still.imu_of_others > 0;
  if (other_unit) chosen.imu_sensor = -1;
  if (other_unit || pass->better_codes) {
    context.reporter.debug("reading the recording again, with what was learned about the devices");
    const BroadcastCodes codes = pass->better_codes.value_or(BroadcastCodes{});
    pass = read_once(source, chosen, codes, sink, context);
    if (!pass) return pass.error();
  }
  return std::move(pass->summary);
}

std::optional<Matrix3d> base_rotation(const Rig& rig, const StillStop& stop) {
  if (!stop.rotation_known || stop.imu_sensor < 0) return std::nullopt;
  if (stop.imu_sensor == rig.base) return stop.R_previous_this;
  const auto& guess = rig.sensors[static_cast<std::size_t>(stop.imu_sensor)].initial_T_base_sensor;
  if (!guess) return std::nullopt;
  return guess->R * stop.R_previous_this * guess->R.transpose();
}

std::optional<Error> reading_error(const StreamSource& source, const StopOptions& options, const StopReading& summary) {
  if (summary.ingest.unfit) {
    Error error = *summary.ingest.unfit;
    error.where = source.path;
    return error;
  }
  if (summary.still.imu_samples == 0) {
    return input_error("no LiDAR of the rig sent inertial readings, by which the stops are found", source.path,
                       "switch the inertial unit of the AVIA on (imu: true in the rig file) and record again");
  }
  if (summary.stops.empty()) {
    char text[200];
    std::snprintf(text, sizeof text,
                  "the rig never stands still: its longest rest has %.2f s, %.2f s are needed (noise of the gyro: "
                  "%.3f deg/s)",
                  summary.still.longest_still_s, options.min_stop_s, to_deg(summary.still.gyro_noise_rad_s));
    return input_error(text, source.path, "let it rest for two seconds and more at every stop");
  }
  return std::nullopt;
}

std::vector<std::string> reading_warnings(const StreamSource& source, const StopReading& summary) {
  std::vector<std::string> warnings = summary.ingest.warnings;
  if (!summary.truncation.empty()) warnings.push_back(source.file + ": " + summary.truncation);
  for (const std::string& finding : summary.notes.findings) warnings.push_back(source.file + ": " + finding);
  if (!source.complete) {
    warnings.push_back(source.path + ": the recording was cut short; what is there is used");
  }
  if (summary.still.bias_changes > 0) {
    warnings.emplace_back("what was first taken for rest was a slow steady rotation: the first stops are doubtful");
  }
  const auto overflow = summary.points.dropped[static_cast<std::size_t>(DropReason::overflow)];
  if (overflow > 0) {
    warnings.push_back(std::to_string(overflow) + " points came too densely to be held until their stop was sure");
  }
  for (const StopRecord& stop : summary.stops) {
    if (stop.rotation_known) continue;
    warnings.push_back("the inertial unit was silent before stop " + std::to_string(stop.stop.index) +
                       ": how far the rig turned there is not known");
  }
  return warnings;
}

}  // namespace rigcal
