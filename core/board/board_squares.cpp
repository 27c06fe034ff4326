#include "core/board/board_squares.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/board/squares_fit.h"

namespace rigcal {
namespace {

using Eigen::Vector2d;

constexpr std::size_t most_scored = 20000;
constexpr std::size_t least_scored = 300;
constexpr double clear_contrast = 0.8;  // difference of the colours' means over their spread
constexpr double as_clear = 0.9;        // of the clearest: then the place nearest to the outline's tells
constexpr double beside_line = 0.12;    // of a square: nearer to a line the beam meets both colours
constexpr double slope_reach = 0.25;    // of a square
constexpr double across_sigmas = 3.0;
// What no averaging over points takes away: a sensor's own directions are bent by so much across a board.
constexpr double place_floor_m = 0.001;
constexpr double bend_floor_m = 0.0005;  // from the board's middle to its ends

struct Colours {
  double n[2] = {};
  double sum[2] = {};
  double squares[2] = {};

  void add(int which, double value) {
    n[which] += 1.0;
    sum[which] += value;
    squares[which] += value * value;
  }
  [[nodiscard]] double mean(int which) const { return sum[which] / std::max(1.0, n[which]); }
  [[nodiscard]] double variance(int which) const {
    return std::max(0.0, squares[which] / std::max(1.0, n[which]) - mean(which) * mean(which));
  }
  /// Positive where the squares of the first one's colour are the darker ones.
  [[nodiscard]] double contrast() const {
    const double spread = std::sqrt(0.5 * (variance(0) + variance(1)) + 1e-6);
    return n[0] < 50.0 || n[1] < 50.0 ? 0.0 : (mean(1) - mean(0)) / spread;
  }
};

// `by` in metres at the pattern's outermost lines: along x, along y, about the normal.
SquaresPlace shifted(SquaresPlace place, int axis, double by, const BoardModel& board) {
  if (axis < 2) {
    place.shift[axis] += by;
  } else {
    place.angle_rad += by / (0.5 * board.size().maxCoeff());
  }
  return place;
}

Vector2d moved_back(const Vector2d& p, const SquaresPlace& place) {
  const double c = std::cos(place.angle_rad);
  const double s = std::sin(place.angle_rad);
  const Vector2d q = p - place.shift;
  return {c * q.x() + s * q.y(), -s * q.x() + c * q.y()};
}

// Where the ray of a point meets the board's plane, in the board's frame: what a range is off by moves a point along a
// slanting ray, and the squares with it.
Vector2d met_by_ray(const SE3& to_board, const Vector3d& q) {
  const Vector3d& from = to_board.t;  // the sensor
  return (from + (q - from) * (from.z() / (from.z() - q.z()))).head<2>();
}

double contrast_at(const std::vector<SquareSpot>& spots, const BoardModel& board, const SquaresPlace& place) {
  Colours colours;
  for (const SquareSpot& spot : spots) {
    const Vector2d q = moved_back(spot.at, place);
    const int colour = board.colour_at(q.x(), q.y(), 0.0);
    if (colour != 0) colours.add(colour > 0 ? 0 : 1, spot.reflectivity);
  }
  return colours.contrast();
}

// Steps along each of the three until none helps, then finer ones.
SquaresPlace sharpest(const std::vector<SquareSpot>& spots, const BoardModel& board) {
  SquaresPlace best;
  double most = std::abs(contrast_at(spots, board, best));
  for (double step = 0.08; step > 0.03; step *= 0.5) {
    for (bool better = true; better;) {
      better = false;
      for (int k = 0; k < 6; ++k) {
        const SquaresPlace next = shifted(best, k / 2, (k % 2 == 0 ? 1.0 : -1.0) * step * board.square(), board);
        if (next.shift.norm() > 0.45 * board.square() || std::abs(next.angle_rad) > to_rad(3.0)) continue;
        const double here = std::abs(contrast_at(spots, board, next));
        if (here <= most + 1e-9) continue;
        most = here;
        best = next;
        better = true;
      }
    }
  }
  return best;
}

// The middle of the contrast's slopes to both sides along each of the three: its very peak is made by the few points
// next to the lines, the slopes by many.
SquaresPlace centred(const std::vector<SquareSpot>& spots, const BoardModel& board, SquaresPlace at) {
  const double reach = slope_reach * board.square();
  for (int pass = 0; pass < 3; ++pass) {
    for (int axis = 0; axis < 3; ++axis) {
      const double peak = std::abs(contrast_at(spots, board, at));
      const double plus = std::abs(contrast_at(spots, board, shifted(at, axis, reach, board)));
      const double minus = std::abs(contrast_at(spots, board, shifted(at, axis, -reach, board)));
      const double fall = peak - 0.5 * (plus + minus);
      if (fall <= 0.0) continue;
      at = shifted(at, axis, std::clamp(0.5 * reach * (plus - minus) / fall, -0.5 * reach, 0.5 * reach), board);
    }
  }
  return at;
}

struct Laid {
  SE3 turn;  ///< Of the plate.
  SquaresPlace place;
  double contrast = 0.0;
};

std::vector<SquareSpot> turned_back(std::vector<SquareSpot> spots, const SE3& turn) {
  for (SquareSpot& spot : spots) spot.at = (turn.inverse() * Vector3d(spot.at.x(), spot.at.y(), 0.0)).head<2>();
  return spots;
}

// Where one end of the plate has its own colours, the first square is the dark one; the pattern of the other end on
// this one has them the other way round.
bool is_better(const Laid& a, const Laid& b, const BoardModel& board) {
  const bool tells = (board.columns() + board.rows()) % 2 != 0;
  const double by_a = tells ? a.contrast : std::abs(a.contrast);
  const double by_b = tells ? b.contrast : std::abs(b.contrast);
  if (std::min(by_a, by_b) < as_clear * std::max(by_a, by_b)) return by_a > by_b;
  return a.place.shift.norm() + place_floor_m < b.place.shift.norm();
}

// In each turn of the plate in which the squares would lie elsewhere on it.
Laid laid_best(const std::vector<SquareSpot>& spots, const BoardModel& board) {
  std::vector<SE3> turns = board.plate_turns();
  // After half a turn squares in the middle of an oblong plate lie where they did.
  if (turns.size() == 2 && board.offset().isZero()) turns.resize(1);
  std::optional<Laid> best;
  for (const SE3& turn : turns) {
    const std::vector<SquareSpot> seen = turned_back(spots, turn);
    Laid laid{turn, centred(seen, board, sharpest(seen, board)), 0.0};
    laid.contrast = contrast_at(seen, board, laid.place);
    if (!best || is_better(laid, *best, board)) best = laid;
  }
  return *best;
}

// How much farther dark squares seem, by the points' distances from the plate, which then lies where bright squares do.
void take_difference_out(const BoardModel& board, CloudBoard& found) {
  SquareCue& cue = *found.squares;
  const SE3 back = found.T_lidar_board.inverse();
  Colours across;
  for (const Vector3d& p : found.points) {
    const Vector3d q = back * p;
    const Vector2d at = met_by_ray(back, q);
    const int colour = board.colour_at(at.x(), at.y(), beside_line);
    if (colour != 0) across.add((colour > 0) == cue.first_is_dark ? 0 : 1, q.z());
  }
  const double cosine = std::abs(found.T_lidar_board.R.col(2).dot(found.T_lidar_board.t.normalized()));
  cue.dark_farther_m = (across.mean(0) - across.mean(1)) / std::max(0.1, cosine);
  double across_m = 0.0;
  for (Vector3d& p : found.points) {
    const Vector2d at = met_by_ray(back, back * p);
    const int colour = board.colour_at(at.x(), at.y(), 0.0);
    if (colour != 0 && (colour > 0) == cue.first_is_dark) p -= cue.dark_farther_m * p.normalized();
    across_m += (back * p).z() / static_cast<double>(found.points.size());
  }
  // Along the rays, as directions stay.
  const double along_m = across_m / std::max(0.1, cosine);
  found.T_lidar_board.t += along_m * found.T_lidar_board.t.normalized();
  for (BorderPoint& b : found.border) b.p += along_m * b.p.normalized();
}

}  // namespace

void look_at_squares(std::span<const Point> points, const BoardModel& board, CloudBoard& found) {
  const SE3 to_board = found.T_lidar_board.inverse();
  const double tolerance = std::max(0.02, across_sigmas * found.plane_rms_m);
  std::vector<SquareSpot> all;
  for (const Point& point : points) {
    const Vector3d q = to_board * Vector3d(point.x, point.y, point.z);
    if (std::abs(q.z()) > tolerance) continue;
    const Vector2d at = met_by_ray(to_board, q);
    if ((at.cwiseAbs() - 0.5 * board.size()).maxCoeff() > 0.0) continue;
    all.push_back({at, static_cast<double>(point.reflectivity)});
  }
  if (all.size() < least_scored) return;
  std::vector<SquareSpot> spots;
  const std::size_t every = std::max<std::size_t>(1, all.size() / most_scored);
  for (std::size_t k = 0; k < all.size(); k += every) spots.push_back(all[k]);
  const Laid laid = laid_best(spots, board);
  SquaresPlace place = laid.place;
  const double contrast = laid.contrast;
  if (std::abs(contrast) < clear_contrast) return;
  take_turn(found, laid.turn);
  spots = turned_back(std::move(spots), laid.turn);
  SquareCue& cue = found.squares.emplace();
  cue.contrast = std::abs(contrast);
  cue.first_is_dark = contrast > 0.0;
  if (const auto fit = fit_squares(spots, board, place)) {
    place = fit->place;
    const double bend = bend_floor_m / (0.3 * board.size().maxCoeff());
    cue.shift_sigma_m = std::hypot(place_floor_m, fit->shift_sigma_m);
    cue.angle_sigma_rad = std::hypot(bend, fit->angle_sigma_rad);
    cue.scale_sigma = std::hypot(bend, fit->scale_sigma);
  }
  SE3 in_plane;
  in_plane.R = exp_so3({0.0, 0.0, place.angle_rad});
  in_plane.t << place.shift, 0.0;
  found.T_lidar_board = found.T_lidar_board * in_plane;
  cue.T_lidar_pattern = found.T_lidar_board;
  cue.T_lidar_pattern.t /= place.scale;
  take_difference_out(board, found);
}

}  // namespace rigcal
