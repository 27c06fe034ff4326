#include "apps/stop_reader.h"

#include <algorithm>
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

// Rough extrinsics are good enough: a few degrees of the axis do not matter to what shows a turn.
std::map<int, Vector3d> turn_axes(const Rig& rig) {
  std::map<int, Vector3d> axes;
  const Vector3d axis = rig.turntable && rig.turntable->axis ? *rig.turntable->axis : Vector3d(Vector3d::UnitZ());
  for (std::size_t i = 0; i < rig.sensors.size(); ++i) {
    const bool is_base = static_cast<int>(i) == rig.base;
    const std::optional<SE3>& guess = rig.sensors[i].initial_T_base_sensor;
    if (is_base) {
      axes[static_cast<int>(i)] = axis;
    } else if (guess) {
      axes[static_cast<int>(i)] = guess->R.transpose() * axis;
    }
  }
  return axes;
}

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
  pass.summary.source = options.source;
  pass.summary.gyro = finder.gyro_figures();
  pass.summary.view = finder.point_figures();
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
  chosen.turn_axes = turn_axes(source.rig);
  // The base's unit, because its frame is the rig's.
  const std::vector<Sensor>& sensors = source.rig.sensors;
  const bool has_rig = !sensors.empty();  // not so where a dump is only looked at
  if (chosen.imu_sensor < 0 && has_rig && has_imu(source.rig.base_sensor())) chosen.imu_sensor = source.rig.base;
  if (has_rig && std::none_of(sensors.begin(), sensors.end(), has_imu)) chosen.source = StopSource::points;
  BroadcastCodes codes;
  Expected<Pass> pass = read_once(source, chosen, codes, sink, context);
  if (!pass) return pass.error();
  const bool other_unit =
      options.imu_sensor < 0 && pass->summary.gyro.imu_samples == 0 && pass->summary.gyro.imu_of_others > 0;
  if (other_unit) chosen.imu_sensor = -1;
  if (other_unit || pass->better_codes) {
    context.reporter.debug("reading the recording again, with what was learned about the devices");
    codes = pass->better_codes.value_or(BroadcastCodes{});
    pass = read_once(source, chosen, codes, sink, context);
    if (!pass) return pass.error();
  }
  if (!has_rig || chosen.source == StopSource::points || !pass->summary.stops.empty()) return std::move(pass->summary);
  context.reporter.debug("reading the recording again, to find the stops from the points");
  chosen.source = StopSource::points;
  Expected<Pass> by_points = read_once(source, chosen, codes, sink, context);
  if (!by_points) return by_points.error();
  if (by_points->summary.stops.empty() && pass->summary.gyro.imu_samples > 0) return std::move(pass->summary);
  by_points->summary.gyro = pass->summary.gyro;
  return std::move(by_points->summary);
}

std::optional<Matrix3d> base_rotation(const Rig& rig, const StillStop& stop) {
  if (!stop.rotation_known || stop.sensor < 0) return std::nullopt;
  if (stop.sensor == rig.base) return stop.R_previous_this;
  const auto& guess = rig.sensors[static_cast<std::size_t>(stop.sensor)].initial_T_base_sensor;
  if (!guess) return std::nullopt;
  return guess->R * stop.R_previous_this * guess->R.transpose();
}

}  // namespace rigcal
