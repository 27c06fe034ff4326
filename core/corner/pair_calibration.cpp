#include "core/corner/pair_calibration.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/corner/cloud_overlap.h"
#include "core/corner/three_planes.h"
#include "core/start/shape_start.h"

namespace rigcal {
namespace {

constexpr std::size_t most_candidates = 48;
constexpr double least_score = 0.25;
constexpr double guess_reach_rad = to_rad(60.0);  // farther from the guess than this nobody means
constexpr double level_rad = to_rad(20.0);
constexpr double off_plane_sigmas = 4.0;
constexpr double off_plane_m = 0.1;
constexpr std::size_t least_clutter = 60;  // shapes
constexpr double least_clutter_score = 0.35;
constexpr double uneven_m = 0.01;
constexpr double clearly_better = 0.01;       // of the score
constexpr double ambiguous_near_guess = 0.9;  // of the score
constexpr double ambiguous = 0.75;            // without a guess
constexpr double ambiguous_order = 0.6;

struct Scored {
  AlignmentCandidate candidate;
  double score = 0.0;
};

bool is_allowed(const SE3& T, const PlaneView& a, const PlaneView& b, const std::optional<SE3>& guess) {
  if (a.up && b.up && std::acos(std::clamp(a.up->dot(T.R * *b.up), -1.0, 1.0)) > level_rad) return false;
  return !guess || rotation_distance(guess->R, T.R) < guess_reach_rad;
}

std::string why_no_planes(const PlaneView& view, const char* which) {
  if (view.planes.size() < 3) {
    return "only " + std::to_string(view.planes.size()) + " of at least three planes found in what " + which + " saw";
  }
  if (best_independence(view.planes) < least_independence) {
    return "the planes that " + std::string(which) + " saw are nearly parallel to each other or to one line";
  }
  return {};
}

PairPlacement by_planes(const PlaneView& a, const PlaneView& b, const std::optional<SE3>& guess) {
  PairPlacement out;
  out.why_not = why_no_planes(a, "{a}");
  if (out.why_not.empty()) out.why_not = why_no_planes(b, "{b}");
  if (!out.why_not.empty()) return out;
  const CloudOverlap overlap(a.cloud.cells, b.cloud.cells, shape_levels()[1]);
  std::vector<Scored> scored;
  for (const AlignmentCandidate& c : alignment_candidates(a.planes, b.planes, most_candidates)) {
    if (is_allowed(c.T_a_b, a, b, guess)) scored.push_back({c, overlap.score(c.T_a_b)});
  }
  std::stable_sort(scored.begin(), scored.end(), [](const auto& x, const auto& y) { return x.score > y.score; });
  if (scored.empty()) {
    out.why_not = "no three planes of {a} and {b} have the same angles between them";
    return out;
  }
  out.score = scored[0].score;
  if (out.score < least_score) {
    out.why_not = "what {a} and {b} saw does not overlap (best match " +
                  std::to_string(static_cast<int>(std::lround(100.0 * out.score))) + " %)";
    return out;
  }
  out.matches = scored[0].candidate.matches;
  if (out.matches.size() < 3 || matched_independence(a.planes, out.matches) < least_independence) {
    out.why_not = "fewer than three independent planes are seen by both {a} and {b}";
    return out;
  }
  out.found = true;
  out.T_a_b = scored[0].candidate.T_a_b;
  if (scored.size() > 1) out.runner_up_score = scored[1].score;
  const auto other = std::find_if(scored.begin() + 1, scored.end(), [&](const Scored& s) {
    return s.candidate.agreement > 0.0 && matched_independence(a.planes, s.candidate.matches) >= least_independence;
  });
  if (other != scored.end()) out.other_order_score = other->score;
  return out;
}

// What of a cloud lies on none of its planes.
PatchCells off_planes(const PlaneView& view) {
  PatchCells rest;
  for (const Cell& cell : view.cloud.cells.cells) {
    const bool on_plane = std::any_of(view.planes.begin(), view.planes.end(), [&](const SeenPlane& seen) {
      return std::abs(seen.plane.distance(cell.mean)) < off_plane_sigmas * seen.plane.sigma_m + off_plane_m;
    });
    if (!on_plane) rest.cells.push_back(cell);
  }
  return rest;
}

// Where planes leave a place open, only what stands on them can hold it: two bare walls do not.
bool is_held_by_clutter(const PlaneView& a, const PlaneView& b, const SE3& T_a_b) {
  const CloudOverlap rest(off_planes(a), off_planes(b), shape_levels()[1]);
  return rest.shapes() >= least_clutter && rest.score(T_a_b) >= least_clutter_score;
}

// The turns and places around the guess in which b's plane lies on a's.
std::vector<SE3> places_on_plane(const SeenPlane& a, const SeenPlane& b, const SE3& guess) {
  constexpr double turn_rad = to_rad(4.0);
  constexpr int turns = 8;
  constexpr double shift_m = 0.7;
  const Matrix3d level = turn_onto(guess.R * b.plane.normal, a.plane.normal) * guess.R;
  const Vector3d along = a.plane.normal.unitOrthogonal();
  const Vector3d across = a.plane.normal.cross(along);
  std::vector<SE3> out;
  for (int turn = -turns; turn <= turns; ++turn) {
    const Matrix3d R = exp_so3(turn * turn_rad * a.plane.normal) * level;
    for (int x = -1; x <= 1; ++x) {
      for (int y = -1; y <= 1; ++y) {
        SE3 T{R, guess.t + shift_m * (x * along + y * across)};
        T.t -= a.plane.distance(T * b.plane.points.mean()) * a.plane.normal;
        out.push_back(T);
      }
    }
  }
  return out;
}

ShapeMatch lay_shapes(const PlaneView& a, const PlaneView& b, const std::vector<SE3>& candidates) {
  std::vector<PatchCells> patches{a.cloud.cells, b.cloud.cells};
  patches[0].lidar = 0;
  patches[1].lidar = 1;
  for (PatchCells& patch : patches) patch.stop = 0;
  return ShapeMap(patches, 0, {SE3{}}, {1}).place(patches, 1, candidates);
}

bool is_uneven(const SeenPlane& seen) { return seen.unevenness_m > uneven_m; }

// A road is crowned: what one sees of it near by and the other far away are not one plane, and all that both saw tells
// better how they lie.
void prefer_shapes_of_uneven(const PlaneView& a, const PlaneView& b, PairPlacement& placed) {
  const bool uneven = std::any_of(placed.matches.begin(), placed.matches.end(), [&](const auto& match) {
    return is_uneven(a.planes[match.first]) || is_uneven(b.planes[match.second]);
  });
  if (!uneven) return;
  const ShapeMatch match = lay_shapes(a, b, {placed.T_a_b});
  const CloudOverlap overlap(a.cloud.cells, b.cloud.cells, shape_levels().back());
  if (overlap.score(match.X) < overlap.score(placed.T_a_b) + clearly_better) return;
  placed.T_a_b = match.X;
  placed.by_shapes = match;
}

// Two planes, or a plane and clutter: the largest plane and the shapes of everything.
PairPlacement by_shapes(const PlaneView& a, const PlaneView& b, const SE3& guess, PairPlacement out) {
  std::vector<SE3> candidates;
  for (std::size_t i = 0; i < std::min<std::size_t>(2, a.planes.size()); ++i) {
    for (std::size_t j = 0; j < std::min<std::size_t>(2, b.planes.size()); ++j) {
      const double cosine = a.planes[i].plane.normal.dot(guess.R * b.planes[j].plane.normal);
      if (cosine < std::cos(guess_reach_rad)) continue;
      const auto places = places_on_plane(a.planes[i], b.planes[j], guess);
      candidates.insert(candidates.end(), places.begin(), places.end());
    }
  }
  if (candidates.empty()) return out;
  const ShapeMatch match = lay_shapes(a, b, candidates);
  if (match.score < least_score || !is_allowed(match.X, a, b, guess) || !is_held_by_clutter(a, b, match.X)) return out;
  out.found = true;
  out.T_a_b = match.X;
  out.score = match.score;
  out.runner_up_score = is_allowed(match.runner_up, a, b, guess) ? match.runner_up_score : 0.0;
  out.by_shapes = match;
  out.matches = match_planes(a.planes, b.planes, match.X, PlaneMatchTolerance{to_rad(4.0), 0.15});
  return out;
}

}  // namespace

PlaneView plane_view(PlaneCloud cloud) {
  PlaneView view;
  view.planes = find_planes(cloud);
  view.cloud = std::move(cloud);
  return view;
}

bool is_one_of_two(const PairPlacement& placed, bool has_guess) {
  if (has_guess) return placed.runner_up_score > ambiguous_near_guess * placed.score;
  return placed.runner_up_score > ambiguous * placed.score || placed.other_order_score > ambiguous_order * placed.score;
}

PairPlacement place_pair(const PlaneView& a, const PlaneView& b, const std::optional<SE3>& guess) {
  PairPlacement placed = by_planes(a, b, guess);
  if (placed.found) prefer_shapes_of_uneven(a, b, placed);
  if (placed.found || !guess) return placed;
  return by_shapes(a, b, *guess, placed);
}

}  // namespace rigcal
