#include "apps/commands/result_export.h"

#include <filesystem>
#include <map>
#include <optional>

#include "core/io/output_file.h"
#include "core/report/report_file.h"

namespace rigcal {
namespace {

namespace fs = std::filesystem;

struct ReadResult {
  CalibrationResult result;
  std::map<std::string, CameraIntrinsics> intrinsics;
  std::optional<ReportFile> report;  ///< Of a result folder.
  bool is_rig = false;
};

Expected<ReadResult> read_result(const std::string& path) {
  const Expected<ExtrinsicsFile> extrinsics = load_extrinsics(path);
  if (!extrinsics) return extrinsics.error();
  Expected<CalibrationResult> result = result_from(*extrinsics, path);
  if (!result) return result.error();
  Expected<std::optional<ReportFile>> report = read_report(path);
  if (!report) return report.error();
  return ReadResult{std::move(*result), extrinsics->intrinsics, std::move(*report), extrinsics->is_rig};
}

// The sensor of that name as a camera; of a rig that does not have it, a new one.
Sensor& camera_of(Rig& rig, const std::string& name) {
  const int index = rig.find(name);
  Sensor& sensor = index < 0 ? rig.sensors.emplace_back() : rig.sensors[static_cast<std::size_t>(index)];
  sensor.name = name;
  if (!sensor.camera) sensor.camera.emplace();
  return sensor;
}

// A sensor with intrinsics is a camera, whatever else is known of it; what was found counts more than what was known
// before.
void add_intrinsics(const std::map<std::string, CameraIntrinsics>& intrinsics, std::optional<Rig>& rig) {
  for (const auto& [name, found] : intrinsics) {
    if (!rig) rig.emplace();
    Sensor& sensor = camera_of(*rig, name);
    sensor.lidar.reset();
    sensor.camera->intrinsics = found;
  }
}

// A run knows its cameras; a rig file that has them knows better.
void add_cameras(const ReportFile& report, std::optional<Rig>& rig) {
  for (const std::string& name : report.cameras) {
    if (!rig) rig.emplace();
    if (rig->find(name) < 0) camera_of(*rig, name);
  }
  for (const auto& [name, used] : report.intrinsics) {
    const int index = rig ? rig->find(name) : -1;
    if (index < 0) continue;
    std::optional<CameraSettings>& camera = rig->sensors[static_cast<std::size_t>(index)].camera;
    if (camera && !camera->intrinsics) camera->intrinsics = used;
  }
}

bool tells_cameras_apart(ResultFormat format) {
  return format == ResultFormat::mlcc || format == ResultFormat::kalibr || format == ResultFormat::colmap ||
         format == ResultFormat::fast_livo;
}

}  // namespace

Expected<ResultExport> export_result_file(const std::string& path, const std::string& rig_path, ResultFormat format,
                                          const std::string& out) {
  const Expected<ReadResult> read = read_result(path);
  if (!read) return read.error();
  const CalibrationResult& result = read->result;
  std::optional<Rig> rig;
  if (const std::string& known = rig_path.empty() && read->is_rig ? path : rig_path; !known.empty()) {
    Expected<Rig> loaded = load_rig(known);
    if (!loaded) return loaded.error();
    rig = std::move(*loaded);
  }
  if (read->report) add_cameras(*read->report, rig);
  add_intrinsics(read->intrinsics, rig);
  std::error_code error;
  if (fs::exists(fs::symlink_status(out, error))) {
    return input_error("exists already", out, "choose another --out, or move it away yourself");
  }
  Expected<ExportedResult> exported = export_result(result, rig ? &*rig : nullptr, format);
  if (!exported) return Error{exported.error().kind, exported.error().what, path, exported.error().mend};
  if (const fs::path above = fs::path(out).parent_path(); !above.empty()) {
    fs::create_directories(above, error);
    if (error) return cannot_write(above.string(), error.value());
  }
  if (const Expected<void> written = replace_file(out, exported->text); !written) return written.error();
  ResultExport done;
  done.sensors = std::move(exported->sensors);
  done.warnings = std::move(exported->warnings);
  if (!rig && !read->report && tells_cameras_apart(format)) {
    done.warnings.push_back(
        "no sensor is known for a camera, so that all of them are written as LiDARs: give --rig RIG where there are "
        "some");
  }
  if (!rig && !read->report && format == ResultFormat::opencv)
    done.warnings.push_back(
        "no sensor is known for a camera, so that none has intrinsics: give --rig RIG where there are some");
  if (!rig_path.empty() && tells_cameras_apart(format)) {
    for (const std::string& name : done.sensors) {
      if (rig->find(name) >= 0) continue;
      done.warnings.push_back(name + " is not in " + rig_path +
                              ", so that it is written as a LiDAR: add it there, or name the rig file of this result");
    }
  }
  done.status = result.status;
  done.is_judged = result.is_judged;
  for (const SensorResult& sensor : result.sensors) {
    if (!sensor.T_base_sensor) done.left_out.push_back(sensor.name);
  }
  return done;
}

}  // namespace rigcal
