#include "apps/recording/recorded_formats.h"

#include <filesystem>

#include "core/io/output_file.h"
#include "core/records/pixel_format.h"

namespace rigcal {
namespace {

Expected<void> write_rig_file(const std::string& folder, const Rig& rig) {
  return replace_file((std::filesystem::path(folder) / "rig.yaml").string(), write_rig(rig));
}

}  // namespace

bool is_misread(const std::string& recorded, const std::string& told) {
  const auto as_recorded = parse_pixel_format(recorded);
  const auto as_told = parse_pixel_format(told);
  if (recorded.empty() || !as_recorded || as_recorded->channels() == 3) return false;
  return !as_told || as_told->layout != as_recorded->layout;
}

Expected<void> name_formats(const std::string& folder, Rig rig, const std::map<int, std::string>& formats,
                            Reporter& reporter) {
  if (formats.empty()) return {};
  for (const auto& [number, format] : formats) {
    Sensor& camera = rig.sensors[static_cast<std::size_t>(number)];
    camera.camera->pixel_format = format;
    reporter.warn(camera.name + ": its images are " + format +
                  ", which the rig file does not say: rig.yaml beside them has pixel_format: " + format);
  }
  return write_rig_file(folder, rig);
}

Expected<void> take_back_rings(const std::string& folder, Rig& rig, Reporter& reporter) {
  bool changed = false;
  for (Sensor& sensor : rig.sensors) {
    if (!sensor.lidar || !sensor.lidar->rings) continue;
    sensor.lidar->rings = false;
    changed = true;
    reporter.warn(sensor.name +
                  ": its clouds are written without the numbers of their rings, which only those of a patch folder "
                  "bring along: rig.yaml beside them does not say rings: true");
  }
  return changed ? write_rig_file(folder, rig) : Expected<void>{};
}

}  // namespace rigcal
