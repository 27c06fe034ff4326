#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <utility>

#include "core/base/parallel.h"
#include "core/start/axis_search.h"
#include "core/start/panorama_match.h"
#include "core/start/unguessed.h"

namespace rigcal {
namespace {

// Farther than this is another place.
constexpr double other_m = 0.15;
constexpr double other_rad = to_rad(2.0);
constexpr std::size_t fitted_items = 3000;

std::vector<const PatchSurfels*> patches_of(const std::vector<PatchSurfels>& patches, int lidar, const Start& start) {
  std::vector<const PatchSurfels*> out;
  for (const PatchSurfels& p : patches) {
    if (p.lidar == lidar && start.stop_known[static_cast<std::size_t>(p.stop)]) out.push_back(&p);
  }
  return out;
}

// Several LiDARs as one, in the frame of the first of them.
struct Group {
  std::vector<int> lidars;
  SE3 X;  // T_base_first
  MovingSurfels moving;
  Panorama panorama;
};

Group group_of(const std::vector<int>& lidars, const std::vector<PatchSurfels>& patches, const TurnOfPoses& rig,
               const Start& start) {
  Group out{
      lidars, start.state.T_base_sensor[static_cast<std::size_t>(lidars.front())], {poses_from_first(start), {}}, {}};
  const SE3 T_first_base = out.X.inverse();
  for (const int i : lidars) {
    const SE3 T_first_this = T_first_base * start.state.T_base_sensor[static_cast<std::size_t>(i)];
    for (const PatchSurfels* p : patches_of(patches, i, start)) {
      const SE3 T_zero_first = T_first_base * out.moving.places[static_cast<std::size_t>(p->stop)] * out.X;
      for (const Surfel& s : p->surfels) {
        const MovingSurfels::Item item{p->stop, T_first_this * s.mean, T_first_this.R * s.normal};
        out.moving.items.push_back(item);
        out.panorama.surfels.push_back({T_zero_first * item.mean, T_zero_first.R * item.normal, p->stop});
      }
    }
  }
  out.panorama.turn = rig.turn;
  out.panorama.turn.axis = T_first_base.R * rig.turn.axis;
  out.panorama.turn.foot = T_first_base * rig.turn.foot;
  out.panorama.turn.foot -= out.panorama.turn.foot.dot(out.panorama.turn.axis) * out.panorama.turn.axis;
  return out;
}

std::vector<ScoredPose> laid_as_one(const Group& group, const Panorama& map, const RegistrationResult& leader,
                                    bool drove) {
  std::vector<SE3> candidates{group.X};
  if (leader.runner_up_score > 0.0) candidates.push_back(group.X * leader.X.inverse() * leader.runner_up);
  if (!drove) {
    const std::vector<SE3> some = match_panoramas(map, group.panorama);
    candidates.insert(candidates.end(), some.begin(), some.end());
  }
  const SurfelIndex coarse(without_repetitions(map.surfels, 1.0), 1.0);
  const SurfelIndex fine(without_repetitions(map.surfels, 0.25), 0.5);
  return refined_poses(coarse, fine, group.moving, candidates);
}

// What the first `count` LiDARs that were placed saw, in the rig's frame at zero.
Panorama map_of(const Doubts& doubts, std::size_t count, const std::vector<PatchSurfels>& patches,
                const TurnOfPoses& rig, const Start& start) {
  Panorama out{rig.turn, {}};
  const std::vector<SE3> T_zero_base = poses_from_first(start);
  for (std::size_t k = 0; k < count; ++k) {
    for (const PatchSurfels* p : patches_of(patches, doubts.order[k], start)) {
      const SE3 T = T_zero_base[static_cast<std::size_t>(p->stop)] *
                    start.state.T_base_sensor[static_cast<std::size_t>(p->lidar)];
      for (const Surfel& s : p->surfels) out.surfels.push_back({T * s.mean, T.R * s.normal, 0});
    }
  }
  return out;
}

// All of a group moved by `T_new_old` (base frame).
Start moved(const Group& group, const SE3& T_new_old, const Start& start) {
  Start out = start;
  for (const int i : group.lidars) {
    const auto si = static_cast<std::size_t>(i);
    out.state.T_base_sensor[si] = T_new_old * out.state.T_base_sensor[si];
    out.matches[si].X = T_new_old * out.matches[si].X;
    out.matches[si].runner_up = T_new_old * out.matches[si].runner_up;
  }
  return out;
}

// One way in which everything may stand.
struct Hypothesis {
  Start start;         // as it was laid,
  Start aligned;       // and then;
  SE3 X;               // where the group's first one comes to stand by that,
  double fit = 0.0;    // and how well the group fits there.
  double score = 0.0;  // How well it fitted before.
};

}  // namespace

void reconsider(const Doubts& doubts, const std::vector<PatchSurfels>& patches,
                const std::function<void(Start&)>& align, Start& start) {
  const std::optional<TurnOfPoses> rig = turn_of_poses(start.state.T_G_base, start.stop_known);
  if (!rig) return;
  for (const std::size_t first : doubts.from) {
    const std::vector<int> lidars(doubts.order.begin() + static_cast<std::ptrdiff_t>(first), doubts.order.end());
    const Group group = group_of(lidars, patches, *rig, start);
    const RegistrationResult leader = start.matches[static_cast<std::size_t>(lidars.front())];
    const auto tried = [&](double score, Start placed) {
      Hypothesis h{placed, {}, {}, 0.0, score};
      align(placed);
      const SurfelIndex fine(without_repetitions(map_of(doubts, first, patches, *rig, placed).surfels, 0.25), 0.5);
      const Group there = group_of(lidars, patches, *rig, placed);
      h.X = there.X;
      h.fit = balanced_score(fine, thinned(there.moving, fitted_items), there.X, same_surface_cosine, same_surface_m);
      h.aligned = std::move(placed);
      return h;
    };
    const std::vector<ScoredPose> poses =
        laid_as_one(group, map_of(doubts, first, patches, *rig, start), leader, rig->drove());
    if (poses.empty()) continue;
    std::vector<Hypothesis> hypotheses(2 * poses.size() - 1);
    const auto moved_by = [&](std::size_t k) { return poses[k].X * group.X.inverse(); };
    hypotheses[0] = tried(poses[0].score, moved(group, moved_by(0), start));
    // Poses that were aligned with one place speak for it: each place is tried by itself and from there. In a symmetric
    // scene poses are right for all places, and then better than those before.
    const Start of_first = hypotheses[0].aligned;
    const Group there = group_of(lidars, patches, *rig, of_first);
    const SurfelIndex coarse(without_repetitions(map_of(doubts, first, patches, *rig, of_first).surfels, 1.0), 1.0);
    const MovingSurfels some = thinned(there.moving, fitted_items);
    parallel_for(hypotheses.size() - 1, 1, [&](std::size_t begin, std::size_t end) {
      for (std::size_t h = begin + 1; h < end + 1; ++h) {
        const std::size_t k = (h + 1) / 2;
        if (h % 2 == 1) {
          hypotheses[h] = tried(poses[k].score, moved(group, moved_by(k), start));
        } else {
          const SE3 X = refine_registration(coarse, some, moved_by(k) * there.X, 0.4, 0.1);
          hypotheses[h] = tried(poses[k].score, moved(there, X * there.X.inverse(), of_first));
        }
      }
    });
    std::stable_sort(hypotheses.begin(), hypotheses.end(),
                     [](const Hypothesis& a, const Hypothesis& b) { return a.fit > b.fit; });
    if (hypotheses.front().fit <= 0.0) continue;
    const Hypothesis& best = hypotheses.front();
    const Hypothesis* rival = nullptr;
    double doubt = 0.0;
    for (const Hypothesis& h : hypotheses) {
      // What comes to stand where the best does is the same.
      if ((h.X.t - best.X.t).norm() <= other_m && rotation_distance(h.X.R, best.X.R) <= other_rad) continue;
      const double ratio = std::min(1.0, std::max(h.fit / best.fit, h.score / best.score));
      if (ratio <= doubt) continue;
      doubt = ratio;
      rival = &h;
    }
    start = best.start;
    // The first one's own doubt is answered with it.
    start.matches[static_cast<std::size_t>(lidars.front())].runner_up_score = 0.0;
    if (rival == nullptr) continue;
    const SE3 T_rival_best = rival->X * best.X.inverse();
    for (const int i : lidars) {
      const auto si = static_cast<std::size_t>(i);
      RegistrationResult& match = start.matches[si];
      const double score = doubt * match.score;
      if (score <= match.runner_up_score) continue;
      match.runner_up_score = score;
      match.runner_up = T_rival_best * start.state.T_base_sensor[si];
    }
  }
}

}  // namespace rigcal
