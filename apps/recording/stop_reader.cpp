#include "apps/recording/stop_reader.h"

#include <algorithm>
#include <filesystem>
#include <utility>

#include "apps/recording/rig_lidars.h"
#include "apps/recording/stop_pass.h"
#include "core/io/session_folder.h"
#include "core/rig/text_file.h"

namespace rigcal {

Expected<std::string> rig_file_of_folder(const std::string& folder, const std::string& given) {
  if (!given.empty()) return given;
  std::error_code error;
  std::string own = (std::filesystem::path(folder) / "rig.yaml").string();
  if (std::filesystem::exists(own, error)) return own;
  if (std::filesystem::exists(std::filesystem::path(folder) / "extrinsics.yaml", error))
    return input_error("is a result, and holds no recording", folder, "give the recording that it was made from");
  return input_error("a patch folder needs a rig file", folder, "add --rig RIG.yaml, or put rig.yaml into the folder");
}

Expected<StreamSource> open_stream(const std::string& path, const std::string& rig_path,
                                   const std::optional<RigFile>& known) {
  StreamSource source;
  source.path = path;
  source.file = path;
  source.rig_path = rig_path;
  std::error_code error;
  if (const auto there = check_there(path); !there) return there.error();
  const bool folder = std::filesystem::is_directory(path, error);
  if (folder && !is_session_folder(path)) {
    Expected<std::string> rig_file = rig_file_of_folder(path, rig_path);
    if (!rig_file) return rig_file.error();
    source.rig_path = std::move(*rig_file);
  } else if (folder) {
    Expected<SessionFolder> session = open_session(path);
    if (!session) return session.error();
    source.file = session->packets.empty() ? session->patches : session->packets;
    source.complete = session->record.has_value() && session->record->end_ns.has_value();
    if (rig_path.empty()) source.rig_path = (std::filesystem::path(path) / "rig.yaml").string();
  }
  if (source.rig_path.empty()) return input_error("a recording needs the rig that made it", path, "add --rig RIG");
  Expected<RigFile> rig = known ? Expected<RigFile>(*known) : load_rig_file(source.rig_path);
  if (!rig) return rig.error();
  source.rig = std::move(rig->rig);
  source.rig_text = std::move(rig->text);
  return source;
}

std::optional<Error> no_lidar_error(const StreamSource& source) {
  if (!lidar_sensors(source.rig).empty()) return std::nullopt;
  return input_error("the rig has no LiDAR, by which the stops of a recording are found", source.rig_path,
                     "add it, or give the images by their stops: a folder with image/<camera>/<stop>.png");
}

Expected<StopReading> read_stops(const StreamSource& source, const StopOptions& options, StopSink& sink,
                                 const RunContext& context) {
  const BatchOpener open = [&source](BatchSinks sinks, const BroadcastCodes& codes) {
    return open_batches(source.file, source.rig, std::move(sinks), codes);
  };
  const bool has_rig = !source.rig.sensors.empty();  // not so where a dump is only looked at
  PassPlan plan = first_plan(source.rig, options);
  plan.options.max_held_points = std::max(options.max_held_points, StopOptions::held_points_of_files);
  Expected<StopPass> pass = read_pass(open, source.path, plan, sink, context);
  if (!pass) return pass.error();
  const bool other_unit =
      options.imu_sensor < 0 && pass->reading.gyro.imu_samples == 0 && pass->reading.gyro.imu_of_others > 0;
  if (other_unit) plan.options.imu_sensor = -1;
  if (other_unit || pass->better_codes) {
    context.reporter.debug("reading the recording again, with what was learned about the devices");
    plan.codes = pass->better_codes.value_or(BroadcastCodes{});
    pass = read_pass(open, source.path, plan, sink, context);
    if (!pass) return pass.error();
  }
  if (!has_rig || plan.options.source == StopSource::points || !pass->reading.stops.empty())
    return std::move(pass->reading);
  context.reporter.debug("reading the recording again, to find the stops from the points");
  plan.options.source = StopSource::points;
  Expected<StopPass> by_points = read_pass(open, source.path, plan, sink, context);
  if (!by_points) return by_points.error();
  if (by_points->reading.stops.empty() && pass->reading.gyro.imu_samples > 0) return std::move(pass->reading);
  by_points->reading.gyro = pass->reading.gyro;
  return std::move(by_points->reading);
}

std::optional<double> turned_rad(const StillStop& stop) {
  if (!stop.rotation_known) return std::nullopt;
  return log_so3(stop.R_previous_this).norm();
}

std::optional<GyroTurn> gyro_turn(const std::vector<int>& lidar_sensors, const StillStop& stop) {
  const auto lidar = std::find(lidar_sensors.begin(), lidar_sensors.end(), stop.sensor);
  if (!stop.rotation_known || lidar == lidar_sensors.end()) return std::nullopt;
  return GyroTurn{static_cast<int>(lidar - lidar_sensors.begin()), stop.R_previous_this};
}

std::optional<Matrix3d> base_rotation(const Rig& rig, const StillStop& stop) {
  if (!stop.rotation_known || stop.sensor < 0) return std::nullopt;
  if (stop.sensor == rig.base) return stop.R_previous_this;
  const auto& guess = rig.sensors[static_cast<std::size_t>(stop.sensor)].initial_T_base_sensor;
  if (!guess) return std::nullopt;
  return guess->R * stop.R_previous_this * guess->R.transpose();
}

}  // namespace rigcal
