#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/records/records.h"

namespace rigcal {

/// A return in a row.
struct RowPoint {
  float azimuth_rad = 0.0F;    ///< About the sensor's z, from x towards y; over pi past a sector's begin.
  float elevation_rad = 0.0F;  ///< Above the level through the sensor.
  float range_m = 0.0F;
  std::uint8_t reflectivity = 0;
};

/// What one beam of a LiDAR that spins about its z axis draws: returns at one elevation.
struct ScanRow {
  double step_rad = 0.0;  ///< Median angle between neighbours.
  bool closed = false;    ///< Past the last point comes the first one again; not where only a sector was recorded.
  std::vector<RowPoint> points;  ///< By azimuth.
};

/// The rows that the points of one turn lie on, the lowest first; none where they do not lie on rows (a LiDAR that
/// scans otherwise, or points that were put right for motion). Those beside the rows are left out.
[[nodiscard]] std::vector<ScanRow> find_scan_rows(std::span<const Point> points);

}  // namespace rigcal
