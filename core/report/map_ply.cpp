#include "core/report/map_ply.h"

#include <vector>

#include "core/base/bytes.h"
#include "core/io/output_file.h"
#include "core/report/number_text.h"

namespace rigcal {
namespace {

std::string header(const CalibrationResult& result) {
  std::string text = "ply\nformat binary_little_endian 1.0\ncomment rigcal map, world frame G, metres\n";
  for (std::size_t i = 0; i < result.sensors.size(); ++i) {
    text += "comment sensor " + std::to_string(i) + " " + quoted_text(result.sensors[i].name) + "\n";
  }
  text += "element vertex " + std::to_string(result.map.size()) + "\n";
  text += "property float x\nproperty float y\nproperty float z\nproperty uchar intensity\nproperty uchar sensor\n";
  return text + "end_header\n";
}

}  // namespace

Expected<void> write_map_ply(const CalibrationResult& result, const std::string& path) {
  Expected<OutputFile> file = OutputFile::create(path);
  if (!file) return file.error();
  file->write(header(result));
  std::vector<std::uint8_t> bytes;
  for (const MapPoint& point : result.map) {
    bytes.clear();
    ByteWriter writer(bytes);
    writer.write(point.x);
    writer.write(point.y);
    writer.write(point.z);
    writer.write(point.reflectivity);
    writer.write(point.sensor);
    file->write(bytes);
  }
  if (Expected<void> synced = file->sync(); !synced) return synced;
  return file->close();
}

}  // namespace rigcal
