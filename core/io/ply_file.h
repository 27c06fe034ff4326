#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>

#include "core/base/error.h"
#include "core/io/output_file.h"

namespace rigcal {

/// A vertex of a PLY file, metres in whatever frame the caller says.
struct PlyPoint {
  float x = 0.0F;
  float y = 0.0F;
  float z = 0.0F;
  std::uint8_t reflectivity = 0;
  std::uint8_t sensor = 0;
  std::array<std::uint8_t, 3> rgb{};
};

/// Writes a binary little-endian PLY file point by point: x y z, red green blue, intensity, sensor. The number of
/// vertices is filled in at the end, so it need not be known before.
class PlyWriter {
 public:
  /// Makes the file, or empties an existing one. `remark` becomes a comment of the header, for example what the
  /// sensor numbers mean; one line.
  [[nodiscard]] static Expected<PlyWriter> create(const std::string& path, const std::string& remark = {});

  void write(std::span<const PlyPoint> points);
  /// Completes the file and waits until it is on the disk. The first error of any write is reported here.
  Expected<void> finish();

 private:
  PlyWriter(OutputFile file, std::uint64_t count_offset) : file_(std::move(file)), count_offset_(count_offset) {}

  OutputFile file_;
  std::uint64_t count_offset_ = 0;
  std::uint64_t points_ = 0;
};

}  // namespace rigcal
