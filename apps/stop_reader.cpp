#include "apps/stop_reader.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>

#include "apps/lidar_findings.h"
#include "core/io/session_folder.h"

namespace rigcal {
namespace {

constexpr std::uint64_t datagrams_between_looks = 4096;  // for progress and Ctrl-C: some milliseconds of work

bool has_imu(const Sensor& sensor) {
  if (!sensor.is_lidar() || sensor.lidar->imu == false) return false;
  const LidarModel model = sensor.lidar->model;
  return model == LidarModel::livox_avia || model == LidarModel::livox_horizon || model == LidarModel::livox_tele15;
}

/// Notes the stops on their way to the sink.
class NotingSink final : public PatchSink {
 public:
  NotingSink(PatchSink& sink, std::vector<StopRecord>& stops) : sink_(sink), stops_(stops) {}
  void points(int sensor, int stop, std::span<const Point> points) override { sink_.points(sensor, stop, points); }
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
  BroadcastCodes codes;
  bool learned_too_late = false;
};

Expected<Pass> read_once(const PacketSource& source, const StopOptions& options, const BroadcastCodes& codes,
                         StopSink& sink, const RunContext& context) {
  Pass pass;
  if (const Expected<void> ready = sink.restart(); !ready) return ready.error();
  Expected<PcapReader> reader = PcapReader::open(source.packets);
  if (!reader) return reader.error();
  NotingSink noting(sink, pass.summary.stops);
  StopFinder finder(options, noting);
  LidarIngest ingest(
      source.rig, [&](PointBatch& batch) { finder.add_points(batch); },
      [&](const ImuSample& sample) { finder.add_imu(sample); }, codes);
  std::error_code no_size;
  const auto size = static_cast<double>(std::filesystem::file_size(source.packets, no_size));
  double read = 0.0;
  std::uint64_t count = 0;
  for (Datagram datagram;;) {
    const Expected<bool> more = reader->next(datagram);
    if (!more) return more.error();
    if (!*more) break;
    ingest.add(datagram);
    read += static_cast<double>(datagram.bytes.size()) + 60.0;  // headers of the frame and of the file
    if (++count % datagrams_between_looks != 0) continue;
    if (const Expected<void> status = sink.status(); !status) return status.error();
    if (context.cancelled()) return Error{ErrorKind::cancelled, "stopped", source.path, {}};
    context.reporter.progress("reading packets", no_size || size <= 0.0 ? -1.0 : std::min(1.0, read / size));
  }
  finder.flush();
  if (const Expected<void> status = sink.status(); !status) return status.error();
  pass.summary.ingest = ingest.summary();
  pass.summary.still = finder.figures();
  pass.summary.points = finder.point_counts();
  pass.summary.frames = reader->counters();
  pass.summary.truncation = reader->truncation();
  pass.codes = ingest.codes();
  pass.learned_too_late = ingest.learned_too_late();
  return pass;
}

}  // namespace

Expected<PacketSource> open_packets(const std::string& path, const std::string& rig_path) {
  PacketSource source;
  source.path = path;
  source.packets = path;
  source.rig_path = rig_path;
  std::error_code error;
  if (std::filesystem::is_directory(path, error)) {
    Expected<SessionFolder> session = open_session(path);
    if (!session) return session.error();
    if (session->packets.empty()) {
      return input_error("holds no packets", path, "its patches can be used as they are");
    }
    source.packets = session->packets;
    source.complete = session->record.has_value() && session->record->end_ns.has_value();
    source.rig = std::move(session->rig);
    if (rig_path.empty()) {
      source.rig_path = (std::filesystem::path(path) / "rig.yaml").string();
      return source;
    }
  }
  if (rig_path.empty()) return input_error("a packet dump needs the rig that was recorded", path, "add --rig RIG");
  Expected<Rig> rig = load_rig(rig_path);
  if (!rig) return rig.error();
  source.rig = std::move(*rig);
  return source;
}

Expected<StopReading> read_stops(const PacketSource& source, const StopOptions& options, StopSink& sink,
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
  if (other_unit || pass->learned_too_late) {
    context.reporter.debug("reading the packets again, with what was learned about the devices");
    pass = read_once(source, chosen, BroadcastCodes(pass->codes), sink, context);
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

std::optional<Error> reading_error(const PacketSource& source, const StopOptions& options, const StopReading& summary) {
  if (std::optional<Error> error = ingest_error(source.rig, summary.ingest, false)) {
    error->where = source.path;
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

std::vector<std::string> reading_warnings(const PacketSource& source, const StopReading& summary) {
  std::vector<std::string> warnings = summary.ingest.warnings;
  if (!summary.truncation.empty()) warnings.push_back(source.packets + ": " + summary.truncation);
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
