#include "core/report/map_ply.h"

#include <algorithm>
#include <span>
#include <vector>

#include "core/io/ply_file.h"

namespace rigcal {
namespace {

// Points converted at a time, so that a map of any size is written from a small buffer.
constexpr std::size_t chunk = 65536;

std::string remark(const CalibrationResult& result) {
  std::string text = "rigcal map, world frame G, metres; sensors:";
  for (std::size_t i = 0; i < result.sensors.size(); ++i) {
    text += " " + std::to_string(i) + " " + result.sensors[i].name;
  }
  return text;
}

PlyPoint vertex(const MapPoint& point) {
  return {point.x,      point.y,
          point.z,      point.reflectivity,
          point.sensor, {point.reflectivity, point.reflectivity, point.reflectivity}};
}

}  // namespace

Expected<void> write_map_ply(const CalibrationResult& result, const std::string& path) {
  Expected<PlyWriter> writer = PlyWriter::create(path, remark(result));
  if (!writer) return writer.error();
  std::vector<PlyPoint> vertices;
  for (std::size_t begin = 0; begin < result.map.size(); begin += chunk) {
    const std::size_t size = std::min(chunk, result.map.size() - begin);
    vertices.resize(size);
    const std::span<const MapPoint> part(result.map.data() + begin, size);
    std::transform(part.begin(), part.end(), vertices.begin(), vertex);
    writer->write(vertices);
  }
  return writer->finish();
}

}  // namespace rigcal
