#include "core/report/map_ply.h"

#include <algorithm>
#include <array>
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

PlyPoint vertex(const CalibrationResult& result, std::size_t i) {
  const MapPoint& p = result.map[i];
  const std::array<std::uint8_t, 3> grey{p.reflectivity, p.reflectivity, p.reflectivity};
  return {p.x, p.y, p.z, p.reflectivity, p.sensor, result.map_rgb.empty() ? grey : result.map_rgb[i]};
}

}  // namespace

Expected<void> write_map_ply(const CalibrationResult& result, const std::string& path) {
  Expected<PlyWriter> writer = PlyWriter::create(path, remark(result));
  if (!writer) return writer.error();
  std::vector<PlyPoint> vertices;
  for (std::size_t begin = 0; begin < result.map.size(); begin += chunk) {
    const std::size_t size = std::min(chunk, result.map.size() - begin);
    vertices.resize(size);
    for (std::size_t i = 0; i < size; ++i) vertices[i] = vertex(result, begin + i);
    writer->write(vertices);
  }
  return writer->finish();
}

}  // namespace rigcal
