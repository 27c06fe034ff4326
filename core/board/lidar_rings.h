#pragma once

#include <span>
#include <vector>

#include "core/geometry/se3.h"
#include "core/records/records.h"

namespace rigcal {

/// The points of one laser of a spinning LiDAR, by azimuth. Of several revolutions one point for each column.
struct LidarRing {
  double elevation_rad = 0.0;  ///< Median.
  double step_rad = 0.0;       ///< Median azimuth from point to point.
  std::vector<Vector3d> points;
  std::vector<double> azimuth_rad;
};

/// Cuts a cloud into rings, ordered by elevation. `rings_in_shot`: by Point::shot, else by gaps in elevation. The
/// points begin behind the largest change of range, so that no surface is cut. Empty where the cloud has no rings:
/// fewer than four, or points at all elevations.
[[nodiscard]] std::vector<LidarRing> split_rings(std::span<const Point> points, bool rings_in_shot, double min_range_m);

/// Noise of the ranges (one sigma) by how each differs from its two neighbours' mean, the median over all; at most 5
/// cm.
[[nodiscard]] double range_noise(const std::vector<LidarRing>& rings);

/// Consecutive points of one ring that lie on a line and end where the next surface is clearly elsewhere: what stands
/// free, as a board does.
struct RingSegment {
  int ring = 0;
  std::size_t begin = 0;
  std::size_t end = 0;
  Vector3d middle = Vector3d::Zero();
};

struct SegmentOptions {
  double max_range_m = 10.0;
  double max_length_m = 1.2;
  double line_tolerance_m = 0.05;
};
[[nodiscard]] std::vector<RingSegment> ring_segments(const std::vector<LidarRing>& rings,
                                                     const SegmentOptions& options);

/// Groups of segments by DBSCAN (Ester et al. 1996) on their middles, of two neighbours at least; `reach_m` for each
/// segment: how far its neighbours may be.
[[nodiscard]] std::vector<std::vector<std::size_t>> cluster_segments(const std::vector<RingSegment>& segments,
                                                                     const std::vector<double>& reach_m);

}  // namespace rigcal
