#include "core/start/step_match.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "core/base/best_apart.h"
#include "core/geometry/angles.h"
#include "core/start/step_search.h"

namespace rigcal {
namespace {

// What slid farther than a turn about the table can carry it is likely wrong; its angle may be right.
constexpr double slid_share = 0.3;
// What surfaces leave open stays where it was.
constexpr double pull = 1.0;
constexpr double last_pull = 0.1;
// Tried all round, so far apart, with so many surfels.
constexpr int tried_every_deg = 5;
constexpr std::size_t tried_items = 300;
constexpr double apart_rad = to_rad(5.0);
// What comes to lie as near as this is the same.
constexpr double same_rad = to_rad(2.0);
constexpr double same_m = 0.1;
// Two surfels are seen in one direction within this; they are not of one surface where their ranges differ by more than
// this and this share.
constexpr double same_direction_rad = to_rad(3.0);
constexpr double other_range_m = 0.3;
constexpr double other_range_share = 0.05;
// Fewer surfels matched than this share are no overlap.
constexpr double least_share = 0.15;
// Where a surface is seen under a flatter angle its range says little.
constexpr double flat_cosine = 0.17;
// What is contradicted counts so many times as much as what is met: a wrong turn that lays much on other walls has a
// fifth to a third of that contradicted, the right one at most a tenth.
constexpr double contradiction_weight = 3.0;

SurfelIndex directions_of(const PatchSurfels& patch) {
  std::vector<PlacedSurfel> placed;
  int i = 0;
  for (const Surfel& s : patch.surfels) placed.push_back({s.mean.normalized(), Vector3d::UnitZ(), i++});
  return {placed, 1.2 * same_direction_rad};
}

std::vector<PlacedSurfel> placed_here(const PatchSurfels& patch) {
  std::vector<PlacedSurfel> placed;
  for (const Surfel& s : patch.surfels) placed.push_back({s.mean, s.normal, 0});
  return placed;
}

}  // namespace

StepView::StepView(const PatchSurfels& patch, const Vector3d& axis)
    : axis_(axis),
      moving_{{SE3{}}, {}},
      surfels_(patch.surfels),
      coarse_(placed_here(patch), 1.0),
      fine_(placed_here(patch), 0.5),
      directions_(directions_of(patch)) {
  for (const Surfel& s : patch.surfels) moving_.items.push_back({0, s.mean, s.normal});
}

bool StepView::is_contradicted(const Vector3d& p) const {
  const double range = p.norm();
  if (range <= 0.0) return false;
  const Vector3d d = p / range;
  const int hit = directions_.find(d, Vector3d::UnitZ(), 0.0, 10.0);
  if (hit < 0) return false;
  const PlacedSurfel& seen = directions_[hit];
  if ((seen.mean - d).norm() > same_direction_rad) return false;
  const Surfel& s = surfels_[static_cast<std::size_t>(seen.group)];
  const double cosine = s.normal.dot(d);
  if (std::abs(cosine) < flat_cosine) return false;
  return std::abs(s.normal.dot(s.mean) / cosine - range) > other_range_m + other_range_share * range;
}

double StepView::evidence(const MovingSurfels& after, const SE3& X) const {
  double met = 0.0;
  double contradicted = 0.0;
  double all = 0.0;
  for (const MovingSurfels::Item& item : after.items) {
    const double along = item.normal.dot(axis_);
    const double weight = 1.0 - along * along;
    all += weight;
    const Vector3d p = X * item.mean;
    if (fine_.contains(p, X.R * item.normal, same_surface_cosine, same_surface_m)) {
      met += weight;
    } else if (is_contradicted(p)) {
      contradicted += weight;
    }
  }
  return all > 0.0 ? (met - contradiction_weight * contradicted) / all : 0.0;
}

double StepView::share(const MovingSurfels& after, const SE3& X) const {
  return match_score(fine_, after, X, same_surface_cosine, same_surface_m);
}

std::vector<StepMatch> StepView::matches(const MovingSurfels& after, std::size_t most) const {
  const MovingSurfels few = thinned(after, tried_items);
  std::vector<StepMatch> tried;
  std::vector<StepMatch> starts;
  for (int deg = -180; deg < 180; deg += tried_every_deg) {
    StepMatch match;
    const SE3 turned{exp_so3(to_rad(deg) * axis_), Vector3d::Zero()};
    match.X = refine_registration(coarse_, few, turned, 0.6, 0.25, pull);
    const bool is_new = std::none_of(tried.begin(), tried.end(), [&](const StepMatch& other) {
      return rotation_distance(other.X.R, match.X.R) < same_rad && (other.X.t - match.X.t).norm() < same_m;
    });
    if (is_new) tried.push_back(match);
    // Among clutter, what is drawn from far goes astray.
    starts.push_back({0.0, turned, 0.0, 0.0});
  }
  std::vector<StepMatch> out;
  tried.insert(tried.end(), starts.begin(), starts.end());
  for (StepMatch& match : tried) {
    match.X = refine_registration(fine_, after, match.X, 0.3, 0.08, pull);
    match.X = refine_registration(fine_, after, match.X, 0.15, 0.08, last_pull);
    const std::optional<double> angle = angle_about(axis_, match.X.R);
    if (!angle) continue;
    match.angle = *angle;
    match.score = evidence(after, match.X);
    if (has_slid(match.X)) match.score *= slid_share;
    match.share = share(after, match.X);
    if (match.score > 0.0 || match.share >= least_share) out.push_back(match);
  }
  return best_apart(std::move(out), most,
                    [](const StepMatch& a, const StepMatch& b) { return angle_apart(a.angle, b.angle) < apart_rad; });
}

}  // namespace rigcal
