#include "core/start/unguessed.h"

#include <algorithm>
#include <optional>

#include "core/start/axis_search.h"
#include "core/start/hand_eye.h"
#include "core/start/overlap_limits.h"
#include "core/start/panorama_match.h"

namespace rigcal {
namespace {

// The steps come from poses that were solved.
constexpr double step_sigma_rad = to_rad(0.1);
// Poses that wander farther off a turn about one axis than a table does.
constexpr double wandering_m = 0.03;
// A match as good as this, with no other nearly as good, is sure.
constexpr double sure_score = 0.5;
constexpr double sure_ratio = 0.75;

class Placing {
 public:
  Placing(const StartInput& input, const std::vector<PatchSurfels>& patches, const TurnOfPoses& rig, Start& start)
      : input_(input), patches_(patches), rig_(rig), start_(start), T_zero_base_(poses_from_first(start)) {
    map_.turn = rig.turn;
    own_.resize(static_cast<std::size_t>(input.lidars));
    for (int i = 0; i < input.lidars; ++i) {
      if (start.lidar_known[static_cast<std::size_t>(i)] && (i == input.base || is_sure(i))) add_to_map(i);
    }
  }

  Doubts run() {
    std::vector<int> open;
    for (int i = 0; i < input_.lidars; ++i) {
      const auto si = static_cast<std::size_t>(i);
      if (i == input_.base || (start_.lidar_known[si] && is_sure(i))) continue;
      if (start_.lidar_known[si]) own_[si].near = start_.matches[si];
      if (rig_.drove() ? find_mountings_of(i) : find_own_turns_of(i)) open.push_back(i);
    }
    while (!open.empty()) {
      match(open);
      const auto accepted = std::stable_partition(open.begin(), open.end(), [&](int i) { return !is_sure(i); });
      std::vector<int> found(accepted, open.end());
      open.erase(accepted, open.end());
      if (found.empty()) {
        // Nobody is sure: the one that fits best may help the rest.
        const auto best = std::max_element(open.begin(), open.end(), [&](int a, int b) { return score(a) < score(b); });
        if (score(*best) < min_score) break;
        doubts_.from.push_back(doubts_.order.size());
        found.push_back(*best);
        open.erase(best);
      }
      for (const int i : found) accept(i);
    }
    return doubts_;
  }

 private:
  void accept(int lidar) {
    const auto i = static_cast<std::size_t>(lidar);
    start_.lidar_known[i] = 1;
    start_.state.T_base_sensor[i] = start_.matches[i].X;
    add_to_map(lidar);
  }

  [[nodiscard]] double score(int lidar) const { return start_.matches[static_cast<std::size_t>(lidar)].score; }
  [[nodiscard]] bool is_sure(int lidar) const {
    const RegistrationResult& match = start_.matches[static_cast<std::size_t>(lidar)];
    return match.score >= sure_score && match.runner_up_score < sure_ratio * match.score;
  }

  [[nodiscard]] std::vector<PatchSurfels> patches_of(int lidar) const {
    std::vector<PatchSurfels> out;
    for (const PatchSurfels& p : patches_) {
      if (p.lidar == lidar && !p.surfels.empty() && start_.stop_known[static_cast<std::size_t>(p.stop)])
        out.push_back(p);
    }
    std::sort(out.begin(), out.end(), [](const PatchSurfels& a, const PatchSurfels& b) { return a.stop < b.stop; });
    return out;
  }

  void add_to_map(int lidar) {
    doubts_.order.push_back(lidar);
    const SE3& T = start_.state.T_base_sensor[static_cast<std::size_t>(lidar)];
    for (const PatchSurfels& p : patches_of(lidar)) {
      const SE3 T_zero_this = T_zero_base_[static_cast<std::size_t>(p.stop)] * T;
      for (const Surfel& s : p.surfels) map_.surfels.push_back({T_zero_this * s.mean, T_zero_this.R * s.normal, 0});
    }
  }

  bool find_own_turns_of(int lidar) {
    AxisSearchOptions options;
    options.step_sigma_rad = step_sigma_rad;
    if (rig_.off_m > wandering_m) options.wander_m = 0.2;
    const std::vector<PatchSurfels> patches = patches_of(lidar);
    std::vector<Panorama>& turns = own_[static_cast<std::size_t>(lidar)].turns;
    for (const OwnTurn& turn : find_own_turns(patches, rig_.turn.angle, options)) {
      if (turn.score >= min_own_score) turns.push_back(make_panorama(turn.turn, patches, turn.T_zero_this));
    }
    return !turns.empty();
  }

  bool find_mountings_of(int lidar) {
    std::vector<Mounting>& mountings = own_[static_cast<std::size_t>(lidar)].mountings;
    mountings = find_mountings(patches_of(lidar), T_zero_base_);
    std::erase_if(mountings, [](const Mounting& m) { return m.score < min_own_score; });
    return !mountings.empty();
  }

  void match(const std::vector<int>& lidars) {
    const SurfelIndex coarse(without_repetitions(map_.surfels, 1.0), 1.0);
    const SurfelIndex fine(without_repetitions(map_.surfels, 0.25), 0.5);
    for (const int i : lidars) {
      const auto si = static_cast<std::size_t>(i);
      MovingSurfels moving{T_zero_base_, {}};
      for (const PatchSurfels& p : patches_of(i)) {
        for (const Surfel& s : p.surfels) moving.items.push_back({p.stop, s.mean, s.normal});
      }
      std::vector<SE3> candidates = mountings_on_map(fine, moving, own_[si].mountings, main_axis(T_zero_base_));
      for (const Panorama& turn : own_[si].turns) {
        const std::vector<SE3> some = match_panoramas(map_, turn);
        candidates.insert(candidates.end(), some.begin(), some.end());
      }
      const RegistrationResult far = refine_candidates(coarse, fine, moving, candidates);
      start_.matches[si] = own_[si].near ? nearer_to_guess(*own_[si].near, far) : far;
    }
  }

  // How a LiDAR was carried round, by what it saw itself: about an axis, or, where the rig drove, by its mounting.
  struct Own {
    std::vector<Panorama> turns;
    std::vector<Mounting> mountings;
    std::optional<RegistrationResult> near;  // what fits near its guess, though not surely
  };

  const StartInput& input_;
  const std::vector<PatchSurfels>& patches_;
  const TurnOfPoses& rig_;
  Start& start_;
  std::vector<SE3> T_zero_base_;
  Panorama map_;
  std::vector<Own> own_;  // by LiDAR
  Doubts doubts_;
};

}  // namespace

Doubts place_without_guess(const StartInput& input, const std::vector<PatchSurfels>& patches, Start& start) {
  const std::optional<TurnOfPoses> rig = turn_of_poses(start.state.T_G_base, start.stop_known);
  if (!rig) return {};
  return Placing(input, patches, *rig, start).run();
}

}  // namespace rigcal
