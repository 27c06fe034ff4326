#include "core/io/ply_file.h"

#include <cstring>

namespace rigcal {
namespace {

/// Room for any 64-bit count and the comment that fills what it leaves free.
constexpr std::size_t count_room = 40;
constexpr std::size_t vertex_bytes = 3 * sizeof(float) + 5;

/// "element vertex N" and a comment, always of one length, so that the count can be written over at the end.
std::string count_lines(std::uint64_t count) {
  std::string lines = std::to_string(count) + "\ncomment ";
  lines.resize(count_room, '.');
  return lines;
}

}  // namespace

Expected<PlyWriter> PlyWriter::create(const std::string& path, const std::string& remark) {
  Expected<OutputFile> file = OutputFile::create(path);
  if (!file) return file.error();
  std::string head = "ply\nformat binary_little_endian 1.0\n";
  if (!remark.empty()) head.append("comment ").append(remark).append("\n");
  head += "element vertex ";
  file->write(head);
  file->write(count_lines(0));
  file->write(
      "\nproperty float x\nproperty float y\nproperty float z\nproperty uchar red\nproperty uchar green\n"
      "property uchar blue\nproperty uchar intensity\nproperty uchar sensor\nend_header\n");
  return PlyWriter(std::move(*file), head.size());
}

void PlyWriter::write(std::span<const PlyPoint> points) {
  for (const PlyPoint& point : points) {
    std::uint8_t* room = file_.reserve(vertex_bytes);
    const std::array<float, 3> position{point.x, point.y, point.z};
    std::memcpy(room, position.data(), sizeof(position));
    std::memcpy(room + 12, point.rgb.data(), 3);
    room[15] = point.reflectivity;
    room[16] = point.sensor;
  }
  points_ += points.size();
}

Expected<void> PlyWriter::finish() {
  file_.overwrite(count_offset_, count_lines(points_));
  if (Expected<void> synced = file_.sync(); !synced) return synced;
  return file_.close();
}

}  // namespace rigcal
