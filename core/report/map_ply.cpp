#include "core/report/map_ply.h"

#include <algorithm>

#include "core/base/bytes.h"
#include "core/report/durable_file.h"
#include "core/report/number_text.h"

namespace rigcal {
namespace {

// Points turned into bytes at a time: a map of any size is written from a small buffer.
constexpr std::size_t chunk = 65536;

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
  DurableFile file;
  if (Expected<void> made = file.create(path); !made) return made;
  if (Expected<void> written = file.write(header(result)); !written) return written;
  std::vector<std::uint8_t> bytes;
  for (std::size_t begin = 0; begin < result.map.size(); begin += chunk) {
    bytes.clear();
    ByteWriter writer(bytes);
    const std::size_t end = std::min(result.map.size(), begin + chunk);
    for (std::size_t i = begin; i < end; ++i) {
      const MapPoint& point = result.map[i];
      writer.write(point.x);
      writer.write(point.y);
      writer.write(point.z);
      writer.write(point.reflectivity);
      writer.write(point.sensor);
    }
    const Expected<void> written = file.write({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
    if (!written) return written;
  }
  return file.close();
}

}  // namespace rigcal
