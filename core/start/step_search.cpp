#include "core/start/step_search.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "core/base/best_apart.h"
#include "core/base/parallel.h"
#include "core/geometry/angles.h"

namespace rigcal {
namespace {

// The base of a rig on a table stands no farther from its axis.
constexpr double max_foot_m = 0.6;
constexpr double slack_m = 0.1;
// Axis and table are known to a degree or two.
constexpr double max_tilt_rad = to_rad(3.0);

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
  circle = best_apart(std::move(circle), 16,
                      [](const Step& a, const Step& b) { return angle_apart(a.angle, b.angle) < to_rad(5.0); });
  std::vector<Step> steps;
  for (const Step& s : circle) {
    SE3 X = refine_registration(coarse, moving, {s.R, Vector3d::Zero()}, 0.8, 0.3);
    X = refine_registration(fine, moving, X, 0.3, 0.08);
    const std::optional<double> angle = angle_about(axis, X.R);
    if (!angle) continue;
    double score = match_score(fine, moving, X, same_surface_cosine, same_surface_m);
    // Likely wrong, but its angle may be right.
    if (has_slid(X)) score *= 0.7;
    steps.push_back({*angle, X.R, score});
  }
  return steps;
}

// The step that the scores of all pairs add up to most for; none where fewer than half of the pairs have one like it.
std::optional<double> common_step(const std::vector<std::vector<Step>>& pairs) {
  std::vector<std::vector<StepVote>> votes;
  for (const std::vector<Step>& steps : pairs) {
    std::vector<StepVote>& pair = votes.emplace_back();
    for (const Step& s : steps) pair.push_back({s.angle, s.score});
  }
  const std::optional<double> common = most_voted(votes);
  if (!common) return std::nullopt;
  const auto alike = std::count_if(votes.begin(), votes.end(),
                                   [&](const std::vector<StepVote>& pair) { return vote_for(pair, *common) > 0.0; });
  return 2 * static_cast<std::size_t>(alike) > pairs.size() ? common : std::nullopt;
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

std::optional<double> angle_about(const Vector3d& axis, const Matrix3d& R) {
  const Vector3d phi = log_so3(R);
  const double angle = phi.dot(axis);
  if ((phi - angle * axis).norm() > max_tilt_rad) return std::nullopt;
  return angle;
}

bool has_slid(const SE3& X) {
  return X.t.norm() > 2.0 * max_foot_m * std::abs(std::sin(0.5 * log_so3(X.R).norm())) + slack_m;
}

double vote_for(const std::vector<StepVote>& pair, double angle_rad) {
  double most = 0.0;
  for (const StepVote& vote : pair) {
    const double d = angle_apart(vote.angle, angle_rad);
    if (d < alike_step_rad) most = std::max(most, vote.weight * (1.0 - 0.05 * d / alike_step_rad));
  }
  return most;
}

std::optional<double> most_voted(const std::vector<std::vector<StepVote>>& pairs) {
  double best = 0.0;
  std::optional<double> out;
  for (int deg = -180; deg < 180; ++deg) {
    double sum = 0.0;
    for (const std::vector<StepVote>& pair : pairs) sum += vote_for(pair, to_rad(deg));
    if (sum <= best) continue;
    best = sum;
    out = to_rad(deg);
  }
  return out;
}

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
