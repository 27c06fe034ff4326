#include "apps/commands/result_export.h"

#include <filesystem>
#include <map>
#include <optional>

#include "core/io/output_file.h"

namespace rigcal {
namespace {

namespace fs = std::filesystem;

struct ReadResult {
  CalibrationResult result;
  std::map<std::string, CameraIntrinsics> intrinsics;
};

Expected<ReadResult> read_result(const std::string& path) {
  const Expected<ExtrinsicsFile> extrinsics = load_extrinsics(path);
  if (!extrinsics) return extrinsics.error();
  Expected<CalibrationResult> result = result_from(*extrinsics, path);
  if (!result) return result.error();
  return ReadResult{std::move(*result), extrinsics->intrinsics};
}

// A sensor with intrinsics is a camera, whatever else is known of it; what was found counts more than what was known
// before.
void add_intrinsics(const std::map<std::string, CameraIntrinsics>& intrinsics, std::optional<Rig>& rig) {
  for (const auto& [name, found] : intrinsics) {
    if (!rig) rig.emplace();
    const int index = rig->find(name);
    Sensor& sensor = index < 0 ? rig->sensors.emplace_back() : rig->sensors[static_cast<std::size_t>(index)];
    sensor.name = name;
    if (!sensor.camera) sensor.camera.emplace();
    sensor.lidar.reset();
    sensor.camera->intrinsics = found;
  }
}

}  // namespace

Expected<ResultExport> export_result_file(const std::string& path, const std::string& rig_path, ResultFormat format,
                                          const std::string& out) {
  const Expected<ReadResult> read = read_result(path);
  if (!read) return read.error();
  const CalibrationResult& result = read->result;
  std::optional<Rig> rig;
  if (!rig_path.empty()) {
    Expected<Rig> loaded = load_rig(rig_path);
    if (!loaded) return loaded.error();
    rig = std::move(*loaded);
  }
  add_intrinsics(read->intrinsics, rig);
  std::error_code error;
  if (fs::exists(fs::symlink_status(out, error))) {
    return input_error("exists already", out, "choose another --out, or move it away yourself");
  }
  Expected<ExportedResult> exported = export_result(result, rig ? &*rig : nullptr, format);
  if (!exported) return Error{exported.error().kind, exported.error().what, path, exported.error().mend};
  if (const Expected<void> written = replace_file(out, exported->text); !written) return written.error();
  ResultExport done;
  done.sensors = std::move(exported->sensors);
  done.warnings = std::move(exported->warnings);
  done.status = result.status;
  for (const SensorResult& sensor : result.sensors) {
    if (!sensor.T_base_sensor) done.left_out.push_back(sensor.name);
  }
  return done;
}

}  // namespace rigcal
