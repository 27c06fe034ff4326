#include <algorithm>
#include <cmath>
#include <map>

#include "core/board/board_clouds.h"
#include "core/board/board_squares.h"
#include "core/board/plate_candidate.h"
#include "core/geometry/symmetric_eigen.h"

namespace rigcal {
namespace {

using Eigen::Vector2d;

constexpr double cell_m = 0.1;
constexpr double least_points = 8.0;
constexpr double flat_m = 0.035;    // standard deviation across a cell that may be of a plate
constexpr double flat_ratio = 3.0;  // middle over smallest eigenvalue
constexpr double same_normal = 0.9;
constexpr double same_plane_m = 0.04;
constexpr double on_plane_sigmas = 3.5;
constexpr double least_on_plane_m = 0.03;
constexpr double least_strip_m = 0.02;
constexpr double points_of_strip = 30.0;  // on a strip across the plate: then its ends are known to a thirtieth of it
constexpr double gap_of_strip = 0.15;     // of the plate's shorter side: beyond it another surface begins
constexpr double short_strip = 0.2;       // of that side: strips over the tip of a corner tell little
constexpr double beyond_share = 0.025;    // of the distance: so far outside of an edge the sensor still looks
constexpr double beside_from_m = 0.03;    // outside of a plate's edges: there should be nothing on its plane
constexpr double beside_to_m = 0.15;
constexpr double most_beside = 0.15;  // of the density on the plate

using Key = std::array<int, 3>;

struct FlatCell {
  PointCluster points;
  Vector3d normal = Vector3d::Zero();
  std::vector<std::size_t> members;
  int region = -1;
};

using Cells = std::map<Key, FlatCell>;

Cells make_cells(std::span<const Point> points) {
  Cells cells;
  for (std::size_t k = 0; k < points.size(); ++k) {
    const Vector3d p(points[k].x, points[k].y, points[k].z);
    const double range = p.norm();
    if (!(range > nearest_plate_m) || range > farthest_plate_m) continue;
    FlatCell& cell = cells[{static_cast<int>(std::floor(p.x() / cell_m)), static_cast<int>(std::floor(p.y() / cell_m)),
                            static_cast<int>(std::floor(p.z() / cell_m))}];
    cell.points.add(p);
    cell.members.push_back(k);
  }
  for (auto& [key, cell] : cells) {
    if (cell.points.N < least_points) continue;
    const SymmetricEigen eigen = symmetric_eigen(cell.points.covariance());
    if (eigen.values[0] > flat_m * flat_m || eigen.values[1] < flat_ratio * eigen.values[0]) continue;
    cell.normal = eigen.vectors.col(0);
  }
  return cells;
}

struct Region {
  PointCluster points;
  std::vector<Key> cells;
};

// Grows over neighbouring cells as long as they lie on the region's own plane.
Region grow(Cells& cells, const Key& seed, int id) {
  Region out;
  out.points = cells[seed].points;
  std::vector<Key> open{seed};
  cells[seed].region = id;
  Vector3d normal = cells[seed].normal;
  while (!open.empty()) {
    const Key at = open.back();
    open.pop_back();
    out.cells.push_back(at);
    for (int n = 0; n < 27; ++n) {
      const Key next{at[0] + n % 3 - 1, at[1] + n / 3 % 3 - 1, at[2] + n / 9 - 1};
      const auto found = cells.find(next);
      if (found == cells.end() || found->second.region >= 0) continue;
      FlatCell& cell = found->second;
      if (std::abs(cell.normal.dot(normal)) < same_normal) continue;
      if (std::abs(normal.dot(cell.points.mean() - out.points.mean())) > same_plane_m) continue;
      cell.region = id;
      out.points += cell.points;
      if (out.cells.size() > 3) normal = symmetric_eigen(out.points.covariance()).vectors.col(0);
      open.push_back(next);
    }
  }
  return out;
}

// The points on the region's plane in its cells and in those next to them.
PlateCandidate gather(const Region& region, const Cells& cells, std::span<const Point> points) {
  PlateCandidate out;
  const std::optional<FittedPlane> rough = fit_plane(region.points);
  if (!rough) return out;
  out.plane = *rough;
  std::vector<Key> keys;
  for (const Key& at : region.cells) {
    for (int n = 0; n < 27; ++n) keys.push_back({at[0] + n % 3 - 1, at[1] + n / 3 % 3 - 1, at[2] + n / 9 - 1});
  }
  std::sort(keys.begin(), keys.end());
  keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
  for (int pass = 0; pass < 2; ++pass) {
    const double tolerance = std::max(on_plane_sigmas * std::min(out.plane.sigma_m, flat_m), least_on_plane_m);
    out.points.clear();
    PointCluster fitted;
    for (const Key& key : keys) {
      const auto cell = cells.find(key);
      if (cell == cells.end()) continue;
      for (const std::size_t k : cell->second.members) {
        const Vector3d p(points[k].x, points[k].y, points[k].z);
        if (std::abs(out.plane.distance(p)) > tolerance) continue;
        out.points.push_back(p);
        fitted.add(p);
      }
    }
    if (const auto plane = fit_plane(fitted)) out.plane = *plane;
  }
  return out;
}

// Ends of strips across the points, along both axes of a frame in the plane: the outline of their density. Of n points
// that lie evenly on a strip the last is one of n + 1 equal parts from its end, where the edge does not slant.
void outline_of(const BoardModel& board, const SE3& frame, PlateCandidate& out) {
  out.outline.clear();
  out.outward.clear();
  out.area_m2 = 0.0;
  const SE3 to_plane = frame.inverse();
  std::vector<Vector2d> flat;
  // Where the ray meets the plane: noise of the range moves a point along a slanting ray, and the outermost ones out.
  for (const Vector3d& p : out.points) {
    const double along = out.plane.normal.dot(p) / out.plane.offset_m;
    if (along > 0.5) flat.push_back((to_plane * Vector3d(p / along)).head<2>());
  }
  const double density = static_cast<double>(flat.size()) / board.size().prod();
  const double shorter = board.size().minCoeff();
  const double strip = std::clamp(points_of_strip / (density * shorter), least_strip_m, 0.2 * shorter);
  out.outline_sigma_m = std::hypot(1.0 / (density * strip), 0.003);
  for (int axis = 0; axis < 2; ++axis) {
    std::map<int, std::vector<double>> strips;
    for (const Vector2d& p : flat) strips[static_cast<int>(std::floor(p[1 - axis] / strip))].push_back(p[axis]);
    for (auto& [row, along] : strips) {
      std::sort(along.begin(), along.end());
      // The longest stretch without a gap: what lies in the plane beside the plate is another surface.
      std::size_t best = 0;
      std::size_t best_end = 0;
      std::size_t begin = 0;
      for (std::size_t k = 1; k <= along.size(); ++k) {
        if (k < along.size() && along[k] - along[k - 1] < gap_of_strip * shorter) continue;
        if (k - begin > best_end - best) {
          best = begin;
          best_end = k;
        }
        begin = k;
      }
      if (best_end - best < 6) continue;
      const double low = along[best];
      const double high = along[best_end - 1];
      if (high - low < short_strip * shorter) continue;
      const double part = (high - low) / static_cast<double>(best_end - best - 1);
      // Of each strip its own stretch: a stand or a hand that crosses the plane beside the plate adds next to nothing.
      if (axis == 0) out.area_m2 += (high - low) * strip;
      for (const double sign : {-1.0, 1.0}) {
        Vector3d at = Vector3d::Zero();
        at[axis] = sign > 0.0 ? high + part : low - part;
        at[1 - axis] = (row + 0.5) * strip;
        Vector3d outward = Vector3d::Zero();
        outward[axis] = sign;
        out.outline.push_back(frame * at);
        out.outward.push_back(frame.R * outward);
      }
    }
  }
}

// How many points a cloud has in each small piece of the sphere round the sensor.
class Directions {
 public:
  explicit Directions(std::span<const Point> points) {
    for (const Point& p : points) ++count_[key_of({p.x, p.y, p.z})];
  }
  [[nodiscard]] int count(const Vector3d& direction) const {
    const auto found = count_.find(key_of(direction));
    return found == count_.end() ? 0 : found->second;
  }

 private:
  static constexpr double piece_rad = to_rad(0.6);
  [[nodiscard]] static std::array<int, 3> key_of(const Vector3d& p) {
    const Vector3d unit = p.normalized() / piece_rad;
    return {static_cast<int>(std::floor(unit.x())), static_cast<int>(std::floor(unit.y())),
            static_cast<int>(std::floor(unit.z()))};
  }
  std::map<std::array<int, 3>, int> count_;
};

// Takes the places out of an outline beyond which the sensor does not look, where it does beyond most others: there its
// field of view ends, not the plate.
void drop_ends_of_view(const Directions& directions, PlateCandidate& candidate) {
  std::vector<char> seen;
  std::size_t count = 0;
  for (std::size_t k = 0; k < candidate.outline.size(); ++k) {
    const Vector3d& p = candidate.outline[k];
    const Vector3d beyond = p + beyond_share * p.norm() * candidate.outward[k];
    seen.push_back(directions.count(beyond) > 0 ? 1 : 0);
    count += seen.back() != 0 ? 1U : 0U;
  }
  if (2 * count < seen.size()) return;  // the sky behind it, or points too few to tell
  PlateCandidate kept = candidate;
  kept.outline.clear();
  kept.outward.clear();
  for (std::size_t k = 0; k < seen.size(); ++k) {
    if (seen[k] == 0) continue;
    kept.outline.push_back(candidate.outline[k]);
    kept.outward.push_back(candidate.outward[k]);
  }
  candidate = std::move(kept);
}

// Whether the surface goes on beyond the plate: what looks free only because the points get too sparse there.
bool goes_on(std::span<const Point> points, const BoardModel& board, const CloudBoard& found) {
  const SE3 to_board = found.T_lidar_board.inverse();
  const double tolerance = std::max(least_on_plane_m, on_plane_sigmas * found.plane_rms_m);
  const Vector2d half = 0.5 * board.size();
  double on = 0.0;
  double beside = 0.0;
  for (const Point& point : points) {
    const Vector3d q = to_board * Vector3d(point.x, point.y, point.z);
    if (std::abs(q.z()) > tolerance) continue;
    const double outside = (q.head<2>().cwiseAbs() - half).maxCoeff();
    on += outside < 0.0 ? 1.0 : 0.0;
    beside += outside > beside_from_m && outside < beside_to_m ? 1.0 : 0.0;
  }
  const auto area = [&](double by) { return 4.0 * (half.x() + by) * (half.y() + by); };
  const double area_beside = area(beside_to_m) - area(beside_from_m);
  return beside / area_beside > most_beside * on / area(0.0);
}

bool may_be_plate(const Region& region, const BoardModel& board) {
  const SymmetricEigen eigen = symmetric_eigen(region.points.covariance());
  // Along a side of length a points scatter by a / sqrt(12).
  const double longer = std::sqrt(12.0 * eigen.values[2]);
  const double shorter = std::sqrt(12.0 * eigen.values[1]);
  return longer < 1.5 * board.size().maxCoeff() && shorter > 0.5 * board.size().minCoeff();
}

}  // namespace

CloudBoards find_dense_boards(std::span<const Point> points, const BoardModel& board) {
  CloudBoards out;
  Cells cells = make_cells(points);
  const Directions directions(points);
  std::vector<PlateFit> fits;
  int id = 0;
  for (const auto& [key, cell] : cells) {
    if (cell.region >= 0 || cell.normal.isZero()) continue;
    const Region region = grow(cells, key, id++);
    if (region.cells.size() < 4 || !may_be_plate(region, board)) continue;
    PlateCandidate candidate = gather(region, cells, points);
    if (candidate.points.size() < 50) continue;
    outline_of(board, plane_frame(candidate.plane, candidate.plane.points.mean()), candidate);
    drop_ends_of_view(directions, candidate);
    PlateFit fit = fit_plate(candidate, board);
    if (fit.board) {
      // Once more along the plate's own edges.
      outline_of(board, fit.board->T_lidar_board, candidate);
      drop_ends_of_view(directions, candidate);
      fit = fit_plate(candidate, board);
    }
    if (fit.board && goes_on(points, board, *fit.board)) {
      fit.board.reset();
      fit.why_not = "its surface goes on beyond the plate";
    }
    if (fit.board) {
      look_at_squares(points, board, *fit.board);
      out.boards.push_back(*fit.board);
    }
    fits.push_back(std::move(fit));
  }
  if (out.boards.empty()) out.why_none = why_no_plate(fits, board);
  return out;
}

}  // namespace rigcal
