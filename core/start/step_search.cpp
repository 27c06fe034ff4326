#include "core/start/step_search.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/base/parallel.h"
#include "core/geometry/angles.h"

namespace rigcal {
namespace {

// The base of a rig on a table stands no farther from its axis.
constexpr double max_foot_m = 0.6;

struct Step {
  double angle = 0.0;  // about the axis
  Matrix3d R = Matrix3d::Identity();
  double score = 0.0;
};

std::vector<Step> steps_between(const PatchSurfels& before, const PatchSurfels& after, const Vector3d& axis) {
  std::vector<PlacedSurfel> map;
  for (const Surfel& s : before.surfels) map.push_back({s.mean, s.normal, 0});
  const SurfelIndex coarse(map, 1.0);
  const SurfelIndex fine(map, 0.5);
  MovingSurfels moving{{SE3{}}, {}};
  for (const Surfel& s : after.surfels) moving.items.push_back({0, s.mean, s.normal});
  const MovingSurfels few = thinned(moving, 400);
  std::vector<Step> circle;
  for (int deg = -180; deg < 180; deg += 3) {
    const Matrix3d R = exp_so3(to_rad(deg) * axis);
    circle.push_back({to_rad(deg), R, match_score(coarse, few, {R, Vector3d::Zero()}, std::cos(to_rad(20.0)), 0.3)});
  }
  std::stable_sort(circle.begin(), circle.end(), [](const Step& a, const Step& b) { return a.score > b.score; });
  std::vector<Step> steps;
  std::vector<double> tried;
  for (const Step& s : circle) {
    if (tried.size() >= 16) break;
    if (std::any_of(tried.begin(), tried.end(), [&](double a) { return angle_apart(a, s.angle) < to_rad(5.0); }))
      continue;
    tried.push_back(s.angle);
    SE3 X = refine_registration(coarse, moving, {s.R, Vector3d::Zero()}, 0.8, 0.3);
    X = refine_registration(fine, moving, X, 0.3, 0.08);
    const Vector3d phi = log_so3(X.R);
    const double angle = phi.dot(axis);
    // Axis and table are known to a degree or two.
    if ((phi - angle * axis).norm() > to_rad(3.0)) continue;
    double score = match_score(fine, moving, X, same_surface_cosine, same_surface_m);
    // One that slid farther than a turn about the table can carry it is likely wrong; its angle may be right.
    if (X.t.norm() > 2.0 * max_foot_m * std::abs(std::sin(0.5 * phi.norm())) + 0.1) score *= 0.7;
    steps.push_back({angle, X.R, score});
  }
  return steps;
}

// The step that the scores of all pairs add up to most for; none where fewer than half of the pairs have one like it.
std::optional<double> common_step(const std::vector<std::vector<Step>>& pairs) {
  double best = 0.0;
  std::optional<double> common;
  for (int deg = -180; deg < 180; ++deg) {
    double sum = 0.0;
    std::size_t alike = 0;
    for (const std::vector<Step>& steps : pairs) {
      double most = 0.0;
      for (const Step& s : steps) {
        const double d = angle_apart(s.angle, to_rad(deg));
        // The middle of a cluster of angles counts a little more than its edges.
        if (d < alike_step_rad) most = std::max(most, s.score * (1.0 - 0.05 * d / alike_step_rad));
      }
      sum += most;
      alike += most > 0.0 ? 1 : 0;
    }
    if (sum <= best) continue;
    best = sum;
    common.reset();
    if (2 * alike > pairs.size()) common = to_rad(deg);
  }
  return common;
}

Step choose(const std::vector<Step>& steps, const std::optional<double>& expected, const Vector3d& axis) {
  Step best;
  if (expected) best = {*expected, exp_so3(*expected * axis), 0.0};
  for (const Step& s : steps) {
    if (expected && angle_apart(s.angle, *expected) > alike_step_rad) continue;
    if (s.score > best.score) best = s;
  }
  return best;
}

}  // namespace

std::optional<Matrix3d> known_step(const std::vector<std::optional<Matrix3d>>& R_previous_this, int from, int to) {
  Matrix3d R = Matrix3d::Identity();
  for (auto j = static_cast<std::size_t>(from) + 1; j <= static_cast<std::size_t>(to); ++j) {
    if (j >= R_previous_this.size() || !R_previous_this[j]) return std::nullopt;
    R = R * *R_previous_this[j];
  }
  return R;
}

std::vector<Matrix3d> rotations_from_search(const std::vector<PatchSurfels>& base_patches, int stops,
                                            const Vector3d& axis,
                                            const std::vector<std::optional<Matrix3d>>& R_previous_this,
                                            std::vector<double>& scores) {
  const std::size_t count = base_patches.size();
  std::vector<std::vector<Step>> pairs(count == 0 ? 0 : count - 1);
  parallel_for(pairs.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const std::optional<Matrix3d> known = known_step(R_previous_this, base_patches[i].stop, base_patches[i + 1].stop);
      if (known) {
        pairs[i] = {{log_so3(*known).dot(axis), *known, 1.0}};
      } else {
        pairs[i] = steps_between(base_patches[i], base_patches[i + 1], axis);
      }
    }
  });
  std::vector<std::vector<Step>> neighbours;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    // A rest that was cut in two is no step of the table.
    const std::optional<Matrix3d> known = known_step(R_previous_this, base_patches[i].stop, base_patches[i + 1].stop);
    if (known && rotation_distance(*known, Matrix3d::Identity()) < alike_step_rad) continue;
    if (base_patches[i + 1].stop == base_patches[i].stop + 1) neighbours.push_back(pairs[i]);
  }
  const std::optional<double> common = common_step(neighbours);
  std::vector<Matrix3d> R(static_cast<std::size_t>(stops), Matrix3d::Identity());
  scores.assign(static_cast<std::size_t>(stops), 1.0);
  std::size_t next = 0;
  for (int j = 0; j < stops; ++j) {
    const auto sj = static_cast<std::size_t>(j);
    if (j > 0) R[sj] = R[sj - 1];
    if (next >= count || base_patches[next].stop != j) continue;
    if (next > 0) {
      std::optional<double> expected = common;
      if (known_step(R_previous_this, base_patches[next - 1].stop, j)) expected.reset();
      if (expected) *expected *= j - base_patches[next - 1].stop;
      const Step step = choose(pairs[next - 1], expected, axis);
      R[sj] = nearest_rotation(R[sj] * step.R);
      scores[sj] = step.score;
    }
    ++next;
  }
  return R;
}

}  // namespace rigcal
