#include <algorithm>
#include <cmath>

#include "core/board/board_clouds.h"
#include "core/board/lidar_rings.h"
#include "core/board/plate_candidate.h"
#include "core/corner/ransac_planes.h"

namespace rigcal {
namespace {

constexpr int least_rings = 4;

constexpr double ransac_threshold_m = 0.05;
constexpr double threshold_sigmas = 3.0;  // of the ranges' noise, where that is more
constexpr double line_sigmas = 4.5;       // the same for points of a segment: none of some hundred may lie farther off
constexpr std::size_t planes_of_cluster = 3;
constexpr std::size_t least_segments = 3;
constexpr double on_plane_sigmas = 4.0;
constexpr double least_on_plane_m = 0.045;
constexpr double most_skipped_steps = 8.5;  // a run of a ring goes on over dark squares that gave no return
constexpr double behind_m = 0.05;
constexpr double lost_steps = 1.7;

// How far the middles of neighbouring rings' segments on one board lie apart at most.
double reach_of(const std::vector<LidarRing>& rings, std::size_t r, const Vector3d& place) {
  double spacing = 0.0;
  if (r > 0) spacing = std::max(spacing, rings[r].elevation_rad - rings[r - 1].elevation_rad);
  if (r + 1 < rings.size()) spacing = std::max(spacing, rings[r + 1].elevation_rad - rings[r].elevation_rad);
  return 2.2 * std::min(spacing, to_rad(5.0)) * place.norm() + 0.08;
}

// Where the ray of a ring at an azimuth meets a plane.
std::optional<Vector3d> on_plane(const LidarRing& ring, double azimuth, const FittedPlane& plane) {
  const double c = std::cos(ring.elevation_rad);
  const Vector3d ray(c * std::cos(azimuth), c * std::sin(azimuth), std::sin(ring.elevation_rad));
  const double along = plane.normal.dot(ray);
  if (std::abs(along) < 0.05) return std::nullopt;
  return Vector3d(ray * (plane.offset_m / along));
}

// The plane along the rings: on each the stretch that belongs to the plate.
class Runs {
 public:
  Runs(const std::vector<LidarRing>& rings, const FittedPlane& plane, double max_length_m)
      : rings_(rings),
        plane_(plane),
        tolerance_(std::max(on_plane_sigmas * plane.sigma_m, least_on_plane_m)),
        max_length_m_(max_length_m),
        middle_(rings.size()) {}

  // From the middle of a segment to both sides.
  void add(const RingSegment& segment) {
    const auto r = static_cast<std::size_t>(segment.ring);
    if (!middle_[r]) add(r, (segment.begin + segment.end) / 2);
  }

  // To rings above and below whose segments were joined with what stands beside the plate.
  void grow() {
    for (bool grown = true; grown;) {
      grown = false;
      for (std::size_t r = 0; r < rings_.size(); ++r) {
        if (middle_[r]) continue;
        for (const std::size_t other : {r - 1, r + 1}) {
          if (other >= rings_.size() || !middle_[other] || middle_[r]) continue;
          const auto start = nearest_on(r, *middle_[other], reach_of(rings_, r, *middle_[other]));
          if (start) add(r, *start);
          grown |= middle_[r].has_value();
        }
      }
    }
  }

  [[nodiscard]] PlateCandidate take() const {
    PlateCandidate out = found_;
    out.outline_sigma_m = std::hypot(widest_step_m_ / std::sqrt(12.0), 0.005);
    return out;
  }
  [[nodiscard]] int rings() const {
    return static_cast<int>(std::count_if(middle_.begin(), middle_.end(), [](const auto& m) { return m.has_value(); }));
  }

 private:
  void add(std::size_t r, std::size_t start) {
    const LidarRing& ring = rings_[r];
    if (!is_on(ring, start)) return;
    const std::size_t first = follow(ring, start, -1);
    const std::size_t last = follow(ring, start, 1);
    if (last - first < 2 || (ring.points[last] - ring.points[first]).norm() > max_length_m_) return;
    middle_[r] = 0.5 * (ring.points[first] + ring.points[last]);
    for (std::size_t k = first; k <= last; ++k) {
      if (is_on(ring, k)) found_.points.push_back(ring.points[k]);
    }
    add_end(ring, first, first, -1.0);
    add_end(ring, last, ring.points.size() - 1 - last, 1.0);
  }

  [[nodiscard]] bool is_on(const LidarRing& ring, std::size_t k) const {
    return std::abs(plane_.distance(ring.points[k])) < tolerance_;
  }
  [[nodiscard]] std::optional<std::size_t> nearest_on(std::size_t r, const Vector3d& place, double reach) const {
    std::optional<std::size_t> nearest;
    for (std::size_t k = 0; k < rings_[r].points.size(); ++k) {
      const double distance = (rings_[r].points[k] - place).norm();
      if (distance > reach || !is_on(rings_[r], k)) continue;
      reach = distance;
      nearest = k;
    }
    return nearest;
  }
  // The last point on the plane to one side; single points beside it, and what gave no return, are passed over.
  [[nodiscard]] std::size_t follow(const LidarRing& ring, std::size_t from, int side) const {
    std::size_t last = from;
    std::size_t k = from;
    while (side > 0 ? k + 1 < ring.points.size() : k > 0) {
      k = side > 0 ? k + 1 : k - 1;
      if (std::abs(ring.azimuth_rad[k] - ring.azimuth_rad[last]) > most_skipped_steps * ring.step_rad) break;
      if (is_on(ring, k)) last = k;
    }
    return last;
  }

  // The border lies between the last ray on the plate and the next; where something nearer hides it, nothing is told.
  void add_end(const LidarRing& ring, std::size_t end, std::size_t left, double sign) {
    if (left > 0) {
      const std::size_t next = sign > 0.0 ? end + 1 : end - 1;
      const double step = std::abs(ring.azimuth_rad[next] - ring.azimuth_rad[end]);
      if (step < lost_steps * ring.step_rad) {
        const auto met = on_plane(ring, ring.azimuth_rad[next], plane_);
        if (!met || ring.points[next].norm() < met->norm() + behind_m) return;
      }
    }
    const auto edge = on_plane(ring, ring.azimuth_rad[end] + sign * 0.5 * ring.step_rad, plane_);
    const auto inner = on_plane(ring, ring.azimuth_rad[end] - sign * 0.5 * ring.step_rad, plane_);
    if (!edge || !inner) return;
    found_.outline.push_back(*edge);
    found_.outward.push_back((*edge - *inner).normalized());
    widest_step_m_ = std::max(widest_step_m_, (*edge - *inner).norm());
  }

  const std::vector<LidarRing>& rings_;
  const FittedPlane& plane_;
  double tolerance_;
  double max_length_m_;
  std::vector<std::optional<Vector3d>> middle_;  ///< Of the run on each ring.
  PlateCandidate found_;
  double widest_step_m_ = 0.0;
};

struct RingCandidate {
  PlateCandidate plate;
  int rings = 0;
};

std::optional<RingCandidate> candidate_on(const FittedPlane& rough, const std::vector<LidarRing>& rings,
                                          const std::vector<RingSegment>& segments,
                                          const std::vector<std::size_t>& cluster, double max_length_m) {
  FittedPlane plane = rough;
  RingCandidate out;
  for (int pass = 0; pass < 3; ++pass) {
    Runs runs(rings, plane, max_length_m);
    for (const std::size_t s : cluster) runs.add(segments[s]);
    runs.grow();
    out.plate = runs.take();
    out.rings = runs.rings();
    PointCluster points;
    for (const Vector3d& p : out.plate.points) points.add(p);
    const std::optional<FittedPlane> fitted = fit_plane(points);
    if (!fitted) return std::nullopt;
    out.plate.plane = plane = *fitted;
  }
  return out;
}

bool same_place(const CloudBoard& a, const CloudBoard& b, const BoardModel& board) {
  return (a.T_lidar_board.t - b.T_lidar_board.t).norm() < 0.5 * board.size().minCoeff();
}

}  // namespace

CloudBoards find_ring_boards(std::span<const Point> points, const BoardModel& board, bool rings_in_shot,
                             std::uint64_t seed) {
  CloudBoards out;
  const std::vector<LidarRing> rings = split_rings(points, rings_in_shot, nearest_plate_m);
  if (rings.empty()) {
    out.why_none = "its points are in no rings";
    return out;
  }
  SegmentOptions segmenting;
  segmenting.max_range_m = farthest_plate_m;
  segmenting.max_length_m = 1.15 * board.size().norm();
  const double noise_m = range_noise(rings);
  segmenting.line_tolerance_m = std::max(segmenting.line_tolerance_m, line_sigmas * noise_m);
  const std::vector<RingSegment> segments = ring_segments(rings, segmenting);
  std::vector<double> reach;
  for (const RingSegment& s : segments) reach.push_back(reach_of(rings, static_cast<std::size_t>(s.ring), s.middle));
  std::vector<PlateFit> fits;
  for (const auto& cluster : cluster_segments(segments, reach)) {
    if (cluster.size() < least_segments) continue;
    std::vector<Vector3d> cloud;
    for (const std::size_t s : cluster) {
      const LidarRing& ring = rings[static_cast<std::size_t>(segments[s].ring)];
      for (std::size_t k = segments[s].begin; k < segments[s].end; ++k) cloud.push_back(ring.points[k]);
    }
    RansacOptions ransac;
    ransac.planes = planes_of_cluster;
    ransac.threshold_m = std::max(ransac_threshold_m, threshold_sigmas * noise_m);
    ransac.min_share = 0.2;
    ransac.max_draws = 500;
    ransac.seed = seed;
    for (const FittedPlane& plane : ransac_planes(cloud, ransac)) {
      const auto candidate = candidate_on(plane, rings, segments, cluster, segmenting.max_length_m);
      if (!candidate || candidate->rings < least_rings) continue;
      PlateFit fit = fit_plate(candidate->plate, board);
      if (fit.board) {
        fit.board->rings = candidate->rings;
        const auto known = std::find_if(out.boards.begin(), out.boards.end(),
                                        [&](const CloudBoard& b) { return same_place(b, *fit.board, board); });
        if (known == out.boards.end()) {
          out.boards.push_back(*fit.board);
        } else if (fit.board->points.size() > known->points.size()) {
          *known = *fit.board;
        }
      }
      fits.push_back(std::move(fit));
    }
  }
  if (out.boards.empty()) out.why_none = why_no_plate(fits, board);
  return out;
}

CloudBoards find_cloud_boards(std::span<const Point> points, const BoardModel& board, bool rings_in_shot,
                              std::uint64_t seed) {
  if (split_rings(points, false, nearest_plate_m).empty() &&
      (!rings_in_shot || split_rings(points, true, nearest_plate_m).empty())) {
    return find_dense_boards(points, board);
  }
  CloudBoards found = find_ring_boards(points, board, false, seed);
  // Lasers that do not all look out from one point have no elevations of their own; their number tells them apart.
  if (found.boards.empty() && rings_in_shot) found = find_ring_boards(points, board, true, seed);
  return found;
}

}  // namespace rigcal
