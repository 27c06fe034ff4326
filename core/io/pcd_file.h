#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/io/intensity_range.h"
#include "core/io/output_file.h"
#include "core/records/records.h"

namespace rigcal {

/// What a PCD file held.
struct PcdSummary {
  std::uint64_t points = 0;       ///< Delivered.
  std::uint64_t not_finite = 0;   ///< Left out: a coordinate is NaN or infinite.
  std::uint64_t at_origin = 0;    ///< Left out: (0, 0, 0), which scanners write where nothing came back.
  bool has_reflectivity = false;  ///< There is a field intensity or reflectivity.
  IntensityRange intensity;       ///< As the file has it.
  bool has_ring = false;
  bool size_missing = false;  ///< WIDTH or HEIGHT is 0 although there are points: worth one warning.
  bool moved = false;         ///< VIEWPOINT is not the identity, and is not applied: likewise.
};

/// Reads a PCD file (ascii, binary, binary_compressed) whose fields have x, y and z (F, 4 or 8 bytes) in any order, and
/// hands the points on in chunks, in the file's order. intensity or reflectivity is rounded and kept within 0 .. 255;
/// tag goes to Point::tag and ring to Point::shot; other fields are skipped. Errors (kind input) name the file and,
/// for text, the line: no PCD file, fewer points than the header promises, sizes that contradict each other.
[[nodiscard]] Expected<PcdSummary> read_pcd(const std::string& path,
                                            const std::function<void(std::span<const Point>)>& take);

/// All points of a file at once.
struct PcdCloud {
  std::vector<Point> points;
  PcdSummary summary;
};
[[nodiscard]] Expected<PcdCloud> read_pcd(const std::string& path);

/// What a cloud has besides coordinates, intensity and tag.
struct PcdColumns {
  bool timestamp = false;  ///< Seconds as a double.
  bool ring = false;       ///< Point::shot, where that is the ring.
};

/// Writes a binary PCD file part by part: x y z and intensity as floats, tag as a byte. These read back to the bit;
/// Point::shot, which mostly means something only in its batch, is written as `PcdColumns` say. The number of points is
/// filled in at the end, so it need not be known before.
class PcdWriter {
 public:
  /// Makes the file, or empties an existing one.
  [[nodiscard]] static Expected<PcdWriter> create(const std::string& path, PcdColumns columns = {});

  /// Point::shot counts from `stamp_ns` in steps of `shot_interval_ns`; both matter to the column timestamp only.
  void write(std::span<const Point> points, std::int64_t stamp_ns = 0, double shot_interval_ns = 0.0);
  /// Completes the file. The first error of any write is reported here.
  Expected<void> finish();

 private:
  PcdWriter(OutputFile file, PcdColumns columns) : file_(std::move(file)), columns_(columns) {}

  OutputFile file_;
  PcdColumns columns_;
  std::uint64_t points_ = 0;
};

/// The whole of a cloud at once.
Expected<void> write_pcd(const std::string& path, std::span<const Point> points);

}  // namespace rigcal
