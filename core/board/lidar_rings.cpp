#include "core/board/lidar_rings.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "core/base/median.h"
#include "core/geometry/point_cluster.h"
#include "core/geometry/symmetric_eigen.h"

namespace rigcal {
namespace {

constexpr double min_length_m = 0.08;
constexpr double eigenvalue_ratio = 0.9;  // Largest over the sum.

constexpr double ring_gap_rad = to_rad(0.08);
constexpr double ring_spread_rad = to_rad(0.3);
constexpr std::size_t least_ring_points = 8;
constexpr std::size_t least_rings = 4;
constexpr double most_stray = 0.1;  // of the points: in no ring
constexpr double jump_m = 0.12;
constexpr double most_noise_m = 0.05;
constexpr double most_steps = 3.5;    // without a return, within one segment
constexpr std::size_t most_tail = 3;  // points between two surfaces that hang on a segment's end
constexpr double even_share = 0.5;    // of the mean step, which nearly all steps of one revolution are longer than
constexpr double longest_step_rad = to_rad(1.0);
constexpr double least_column_rad = to_rad(0.1);
constexpr double most_column_rad = to_rad(0.4);

struct Polar {
  Vector3d p;
  double azimuth;
  double elevation;
};

std::vector<std::vector<Polar>> by_elevation(std::vector<Polar> all) {
  std::stable_sort(all.begin(), all.end(), [](const Polar& a, const Polar& b) { return a.elevation < b.elevation; });
  std::vector<std::vector<Polar>> rings;
  std::size_t stray = 0;
  std::size_t begin = 0;
  for (std::size_t k = 1; k <= all.size(); ++k) {
    if (k < all.size() && all[k].elevation - all[k - 1].elevation < ring_gap_rad) continue;
    const bool is_ring =
        k - begin >= least_ring_points && all[k - 1].elevation - all[begin].elevation < ring_spread_rad;
    if (is_ring) {
      rings.emplace_back(all.begin() + static_cast<std::ptrdiff_t>(begin),
                         all.begin() + static_cast<std::ptrdiff_t>(k));
    } else {
      stray += k - begin;
    }
    begin = k;
  }
  if (static_cast<double>(stray) > most_stray * static_cast<double>(all.size())) rings.clear();
  return rings;
}

std::vector<double> steps_of(const std::vector<Polar>& by_azimuth) {
  std::vector<double> steps;
  for (std::size_t k = 1; k < by_azimuth.size(); ++k)
    steps.push_back(by_azimuth[k].azimuth - by_azimuth[k - 1].azimuth);
  return steps;
}

// Several revolutions lie over one another: many points are much nearer to the next than in the mean.
bool is_uneven(const std::vector<Polar>& by_azimuth) {
  std::vector<double> steps = steps_of(by_azimuth);
  std::erase_if(steps, [](double step) { return step > longest_step_rad; });
  if (steps.empty()) return false;
  const double mean = std::accumulate(steps.begin(), steps.end(), 0.0) / static_cast<double>(steps.size());
  return quantile(steps, 0.1) < even_share * mean;
}

// One point for all whose azimuths are that near to one another, at their median range: at an edge that of the surface
// which most of them met.
std::vector<Polar> in_columns(const std::vector<Polar>& by_azimuth, double width_rad) {
  std::vector<Polar> out;
  std::size_t begin = 0;
  for (std::size_t k = 1; k <= by_azimuth.size(); ++k) {
    if (k < by_azimuth.size() && by_azimuth[k].azimuth - by_azimuth[begin].azimuth < width_rad) continue;
    Polar mean{Vector3d::Zero(), 0.0, 0.0};
    std::vector<double> ranges;
    const auto count = static_cast<double>(k - begin);
    for (std::size_t i = begin; i < k; ++i) {
      mean.p += by_azimuth[i].p.normalized();
      mean.azimuth += by_azimuth[i].azimuth / count;
      mean.elevation += by_azimuth[i].elevation / count;
      ranges.push_back(by_azimuth[i].p.norm());
    }
    mean.p = median(std::move(ranges)) * mean.p.normalized();
    out.push_back(mean);
    begin = k;
  }
  return out;
}

LidarRing make_ring(std::vector<Polar> points) {
  std::stable_sort(points.begin(), points.end(), [](const Polar& a, const Polar& b) { return a.azimuth < b.azimuth; });
  // Where the circle is cut: no surface goes on over the largest jump.
  std::size_t cut = 0;
  double largest = -1.0;
  for (std::size_t k = 0; k < points.size(); ++k) {
    const double jump = (points[k].p - points[(k + points.size() - 1) % points.size()].p).norm();
    if (jump > largest) {
      largest = jump;
      cut = k;
    }
  }
  std::rotate(points.begin(), points.begin() + static_cast<std::ptrdiff_t>(cut), points.end());
  for (std::size_t k = points.size() - cut; k < points.size(); ++k) points[k].azimuth += 2.0 * pi;
  std::vector<Polar> columns = points;
  for (double width = least_column_rad; is_uneven(columns) && width <= most_column_rad; width *= 2.0) {
    columns = in_columns(points, width);
  }
  LidarRing ring;
  std::vector<double> elevations;
  for (const Polar& p : columns) {
    ring.points.push_back(p.p);
    ring.azimuth_rad.push_back(p.azimuth);
    elevations.push_back(p.elevation);
  }
  ring.elevation_rad = median(elevations);
  ring.step_rad = median(steps_of(columns));
  return ring;
}

// Splits at the point farthest from the chord until all are near it (Ramer 1972, Duda and Hart 1973).
void split_line(const LidarRing& ring, std::size_t begin, std::size_t end, double tolerance,
                std::vector<std::pair<std::size_t, std::size_t>>& out) {
  std::vector<std::pair<std::size_t, std::size_t>> open{{begin, end}};
  while (!open.empty()) {
    const auto [from, to] = open.back();
    open.pop_back();
    if (to - from < 3) continue;
    // Chords between means of the ends: single points carry the noise of their range.
    const std::size_t few = std::min<std::size_t>(3, (to - from) / 2);
    Vector3d a = Vector3d::Zero();
    Vector3d b = Vector3d::Zero();
    for (std::size_t k = 0; k < few; ++k) {
      a += ring.points[from + k] / static_cast<double>(few);
      b += ring.points[to - 1 - k] / static_cast<double>(few);
    }
    const Vector3d chord = (b - a).normalized();
    double farthest = tolerance;
    std::size_t at = to;
    for (std::size_t k = from + 1; k + 1 < to; ++k) {
      const Vector3d off = ring.points[k] - a;
      const double distance = (off - chord * chord.dot(off)).norm();
      if (distance > farthest) {
        farthest = distance;
        at = k;
      }
    }
    if (at == to) {
      out.emplace_back(from, to);
    } else {
      open.emplace_back(at, to);
      open.emplace_back(from, at + 1);
    }
  }
}

}  // namespace

std::vector<LidarRing> split_rings(std::span<const Point> points, bool rings_in_shot, double min_range_m) {
  std::vector<Polar> all;
  std::map<int, std::vector<Polar>> by_number;
  for (const Point& q : points) {
    const Vector3d p(q.x, q.y, q.z);
    const double range = p.norm();
    if (!(range > min_range_m)) continue;
    const Polar polar{p, std::atan2(p.y(), p.x()), std::asin(p.z() / range)};
    if (rings_in_shot) {
      by_number[q.shot].push_back(polar);
    } else {
      all.push_back(polar);
    }
  }
  std::vector<std::vector<Polar>> found;
  if (rings_in_shot) {
    for (auto& [number, ring] : by_number) {
      if (ring.size() >= least_ring_points) found.push_back(std::move(ring));
    }
  } else {
    found = by_elevation(std::move(all));
  }
  if (found.size() < least_rings) return {};
  std::vector<LidarRing> rings;
  for (auto& ring : found) rings.push_back(make_ring(std::move(ring)));
  std::stable_sort(rings.begin(), rings.end(),
                   [](const LidarRing& a, const LidarRing& b) { return a.elevation_rad < b.elevation_rad; });
  return rings;
}

double range_noise(const std::vector<LidarRing>& rings) {
  std::vector<double> off;
  for (const LidarRing& ring : rings) {
    for (std::size_t k = 1; k + 1 < ring.points.size(); ++k) {
      const double between = 0.5 * (ring.points[k - 1].norm() + ring.points[k + 1].norm());
      off.push_back(std::abs(ring.points[k].norm() - between));
    }
  }
  // Of a normal distribution half lies within 0.6745 sigma; the difference has 1.5 times the variance of one range.
  return std::min(most_noise_m, median(std::move(off)) / (0.6745 * std::sqrt(1.5)));
}

std::vector<RingSegment> ring_segments(const std::vector<LidarRing>& rings, const SegmentOptions& options) {
  std::vector<RingSegment> out;
  for (std::size_t r = 0; r < rings.size(); ++r) {
    const LidarRing& ring = rings[r];
    std::vector<std::pair<std::size_t, std::size_t>> pieces;
    std::vector<std::pair<std::size_t, std::size_t>> lines;
    std::size_t begin = 0;
    for (std::size_t k = 1; k <= ring.points.size(); ++k) {
      if (k < ring.points.size()) {
        const double step = ring.azimuth_rad[k] - ring.azimuth_rad[k - 1];
        const double far = jump_m + 3.0 * ring.points[k].norm() * ring.step_rad;
        if (step < most_steps * ring.step_rad && (ring.points[k] - ring.points[k - 1]).norm() < far) continue;
      }
      lines.clear();
      if (k - begin >= 4) split_line(ring, begin, k, options.line_tolerance_m, lines);
      for (const auto& [from, to] : lines) {
        if (from - begin <= most_tail && k - to <= most_tail) pieces.emplace_back(from, to);
      }
      begin = k;
    }
    for (const auto& [from, to] : pieces) {
      if (to - from < 4) continue;
      PointCluster cluster;
      for (std::size_t k = from; k < to; ++k) cluster.add(ring.points[k]);
      const Vector3d middle = cluster.mean();
      const double length = (ring.points[to - 1] - ring.points[from]).norm();
      if (middle.norm() > options.max_range_m || length > options.max_length_m || length < min_length_m) continue;
      const SymmetricEigen eigen = symmetric_eigen(cluster.covariance());
      if (eigen.values[2] < eigenvalue_ratio * eigen.values.sum()) continue;
      out.push_back({static_cast<int>(r), from, to, middle});
    }
  }
  return out;
}

std::vector<std::vector<std::size_t>> cluster_segments(const std::vector<RingSegment>& segments,
                                                       const std::vector<double>& reach_m) {
  constexpr int none = -1;
  std::vector<int> cluster(segments.size(), none);
  const auto neighbours = [&](std::size_t i) {
    std::vector<std::size_t> out;
    for (std::size_t k = 0; k < segments.size(); ++k) {
      const double reach = std::max(reach_m[i], reach_m[k]);
      if (k != i && (segments[k].middle - segments[i].middle).squaredNorm() < reach * reach) out.push_back(k);
    }
    return out;
  };
  std::vector<std::vector<std::size_t>> out;
  for (std::size_t i = 0; i < segments.size(); ++i) {
    if (cluster[i] != none) continue;
    std::vector<std::size_t> open = neighbours(i);
    if (open.size() < 2) continue;
    const int id = static_cast<int>(out.size());
    out.emplace_back().push_back(i);
    cluster[i] = id;
    while (!open.empty()) {
      const std::size_t k = open.back();
      open.pop_back();
      if (cluster[k] != none) continue;
      cluster[k] = id;
      out.back().push_back(k);
      const std::vector<std::size_t> next = neighbours(k);
      if (next.size() >= 2) open.insert(open.end(), next.begin(), next.end());
    }
    std::sort(out.back().begin(), out.back().end());
  }
  return out;
}

}  // namespace rigcal
