#include "core/corner/rig_placement.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/median.h"
#include "core/corner/cloud_overlap.h"
#include "core/corner/three_planes.h"
#include "core/start/shape_start.h"

namespace rigcal {
namespace {

constexpr PlaneMatchTolerance loose{to_rad(4.0), 0.25};
constexpr PlaneMatchTolerance tight{to_rad(3.0), 0.12};
constexpr double agreeing_m = 0.1;  // places of one LiDAR from two stops
constexpr double agreeing_rad = to_rad(2.0);
constexpr double scale_limit = 25.0;  // of a plane's misfit over the others' before it is no common plane

std::string named(std::string text, const std::string& a, const std::string& b) {
  for (const auto& [mark, name] : {std::pair<std::string, std::string>{"{a}", a}, {"{b}", b}}) {
    for (std::size_t at = text.find(mark); at != std::string::npos; at = text.find(mark, at + name.size())) {
      text.replace(at, mark.size(), name);
    }
  }
  return text;
}

std::size_t index(int i) { return static_cast<std::size_t>(i); }

class RigPlacer {
 public:
  RigPlacer(const RigViews& views, const std::vector<std::optional<SE3>>& guess)
      : views_(views),
        guess_(guess),
        lidars_(static_cast<int>(views.names.size())),
        out_{{}, {}, {}, ParameterLayout(static_cast<int>(views.stops.size()), lidars_), {}, {}, 0.0} {}

  RigPlacement run() {
    out_.state.T_G_base.assign(views_.stops.size(), SE3{});
    out_.state.T_base_sensor.assign(views_.names.size(), SE3{});
    out_.lidars.resize(views_.names.size());
    out_.lidars[index(views_.base)].known = true;
    place_all();
    for (int i = 0; i < lidars_; ++i) {
      if (i != views_.base && is_held_by_planes(i)) out_.layout.free_lidar(i);
    }
    out_.adjust.max_iterations = 50;
    solve(loose);
    solve(tight);
    solve_on_common_parts();
    measure_misfit();
    follow();
    return std::move(out_);
  }

 private:
  // The one that fits best comes first: others may hang on it.
  void place_all() {
    bool found = true;
    while (found) {
      found = false;
      LidarPlacement best;
      int which = -1;
      for (int i = 0; i < lidars_; ++i) {
        if (out_.lidars[index(i)].known) continue;
        LidarPlacement placed = place(i);
        if (!placed.known) {
          if (out_.lidars[index(i)].why_not.empty()) out_.lidars[index(i)].why_not = placed.why_not;
          continue;
        }
        if (which < 0 || is_better(placed.pair, is_sure(placed.pair, i), best.pair, is_sure(best.pair, which))) {
          best = std::move(placed);
          which = i;
        }
      }
      if (which < 0) break;
      out_.state.T_base_sensor[index(which)] = out_.state.T_base_sensor[index(best.via)] * best.pair.T_a_b;
      best.follows = best.pair.by_shapes.has_value() || out_.lidars[index(best.via)].follows;
      out_.lidars[index(which)] = std::move(best);
      order_.push_back(which);
      found = true;
    }
  }

  [[nodiscard]] bool is_sure(const PairPlacement& p, int lidar) const {
    return p.found && !p.by_shapes && !is_one_of_two(p, guess_[index(lidar)].has_value());
  }
  static bool is_better(const PairPlacement& p, bool sure, const PairPlacement& than, bool than_sure) {
    if (sure != than_sure) return sure;
    if (p.found != than.found) return p.found;
    if (p.by_shapes.has_value() != than.by_shapes.has_value()) return than.by_shapes.has_value();
    return p.score > than.score;
  }

  // On the base first; on others only where that leaves doubts.
  LidarPlacement place(int lidar) {
    LidarPlacement best;
    for (int k = -1; k < lidars_ && !is_sure(best.pair, lidar); ++k) {
      const int via = k < 0 ? views_.base : k;
      if (!out_.lidars[index(via)].known || (k >= 0 && k == views_.base)) continue;
      LidarPlacement on_via = place_on(via, lidar);
      if (best.why_not.empty()) best.why_not = on_via.why_not;
      const PairPlacement& placed = on_via.pair;
      if (!placed.found) continue;
      if (best.known && !is_better(placed, is_sure(placed, lidar), best.pair, is_sure(best.pair, lidar))) continue;
      best = std::move(on_via);
    }
    if (!best.known && best.why_not.empty()) best.why_not = "no LiDAR with a known place saw anything when it did";
    return best;
  }

  // A place that one stop tells for sure may be wrong all the same, where a surface is taken for another one behind it;
  // other stops show something else and tell it apart. Of those that agree the surest is taken.
  LidarPlacement place_on(int via, int lidar) {
    LidarPlacement first;
    std::vector<LidarPlacement> places;
    for (std::size_t stop = 0; stop < views_.stops.size(); ++stop) {
      if (!views_.stops[stop][index(via)] || !views_.stops[stop][index(lidar)]) continue;
      PairPlacement placed = pair_of(via, lidar, stop);
      if (first.why_not.empty())
        first.why_not = named(placed.why_not, views_.names[index(via)], views_.names[index(lidar)]);
      if (placed.found) places.push_back({true, {}, std::move(placed), via, static_cast<int>(stop)});
    }
    if (places.empty()) return first;
    const SE3 fitting = fitting_at_all_stops(places, via, lidar);
    const LidarPlacement* best = nullptr;
    for (const LidarPlacement& place : places) {
      const SE3& T = place.pair.T_a_b;
      if ((T.t - fitting.t).norm() > agreeing_m || rotation_distance(T.R, fitting.R) > agreeing_rad) continue;
      if (best == nullptr || is_better(place.pair, is_sure(place.pair, lidar), best->pair, is_sure(best->pair, lidar)))
        best = &place;
    }
    return *best;
  }

  // That of `places` where what both saw lies on each other best, over all stops; of those by planes, if there are any.
  [[nodiscard]] SE3 fitting_at_all_stops(const std::vector<LidarPlacement>& places, int via, int lidar) const {
    if (places.size() == 1) return places.front().pair.T_a_b;
    std::vector<double> scores(places.size(), 0.0);
    for (const auto& stop : views_.stops) {
      if (!stop[index(via)] || !stop[index(lidar)]) continue;
      const CloudOverlap overlap(stop[index(via)]->cloud.cells, stop[index(lidar)]->cloud.cells, shape_levels()[1]);
      for (std::size_t k = 0; k < places.size(); ++k) scores[k] += overlap.score(places[k].pair.T_a_b);
    }
    std::size_t best = 0;
    for (std::size_t k = 1; k < places.size(); ++k) {
      const bool by_planes = !places[k].pair.by_shapes;
      const bool best_by_planes = !places[best].pair.by_shapes;
      if (by_planes != best_by_planes ? by_planes : scores[k] > scores[best]) best = k;
    }
    return places[best].pair.T_a_b;
  }

  PairPlacement pair_of(int a, int b, std::size_t stop) {
    for (const auto& [key, placed] : tried_) {
      if (key.a == a && key.b == b && key.stop == stop) return placed;
    }
    std::optional<SE3> guess;
    if (guess_[index(b)]) guess = out_.state.T_base_sensor[index(a)].inverse() * *guess_[index(b)];
    tried_.push_back({{a, b, stop}, place_pair(*views_.stops[stop][index(a)], *views_.stops[stop][index(b)], guess)});
    return tried_.back().second;
  }

  [[nodiscard]] bool is_held_by_planes(int i) const {
    const LidarPlacement& placed = out_.lidars[index(i)];
    return placed.known && !placed.follows;
  }

  // Those that shapes hold move with the LiDAR that they were laid on, and those on them.
  void follow() {
    for (const int i : order_) {
      const LidarPlacement& placed = out_.lidars[index(i)];
      if (placed.follows) {
        out_.state.T_base_sensor[index(i)] = out_.state.T_base_sensor[index(placed.via)] * placed.pair.T_a_b;
      }
    }
  }

  void solve(const PlaneMatchTolerance& tolerance) {
    std::vector<char> use;
    for (int i = 0; i < lidars_; ++i) use.push_back(is_held_by_planes(i) ? 1 : 0);
    planes_ = find_common_planes(views_, use, out_.state, tolerance);
    const RigState start = out_.state;
    adjust_all(planes_, out_.state);
    if (!drop_misfits()) return;
    out_.state = start;
    adjust_all(planes_, out_.state);
  }

  void adjust_all(const std::vector<CommonPlane>& planes, RigState& state) {
    out_.features = features_of(planes, state);
    out_.adjusted = adjust(out_.features, out_.layout, out_.adjust, state);
  }

  // Until the common parts and the places rest.
  void solve_on_common_parts() {
    constexpr int most_rounds = 8;
    for (int round = 0; round < most_rounds && !planes_.empty(); ++round) {
      std::vector<CommonPlane> planes = on_common_parts(views_, planes_, out_.state);
      if (planes.size() < planes_.size() && !hold_all(planes)) return;
      const RigState before = out_.state;
      planes_ = std::move(planes);
      adjust_all(planes_, out_.state);
      if (moved_by(before) < 1e-6) return;
    }
  }

  [[nodiscard]] double moved_by(const RigState& before) const {
    double most = 0.0;
    for (std::size_t i = 0; i < before.T_base_sensor.size(); ++i) {
      most = std::max(most, (before.T_base_sensor[i].inverse() * out_.state.T_base_sensor[i]).log().norm());
    }
    return most;
  }

  // Whether each LiDAR still has three planes that face different ways.
  [[nodiscard]] bool hold_all(const std::vector<CommonPlane>& planes) const {
    for (int i = 0; i < lidars_; ++i) {
      if (i == views_.base || !is_held_by_planes(i)) continue;
      std::vector<SeenPlane> of_lidar;
      for (const CommonPlane& plane : planes) {
        for (const CommonPlane::Seen& seen : plane.seen) {
          if (seen.lidar == i) of_lidar.push_back(seen.plane);
        }
      }
      if (best_independence(of_lidar) < least_independence) return false;
    }
    return true;
  }

  // Two walls in line are no common plane. True: some were dropped.
  bool drop_misfits() {
    if (planes_.size() < 5) return false;
    std::vector<double> costs;
    for (const PlaneFeature& f : out_.features) costs.push_back(plane_cost(f, out_.state));
    const double limit = scale_limit * std::max(3.0, median(costs));
    std::vector<CommonPlane> kept;
    for (std::size_t k = 0; k < costs.size(); ++k) {
      if (costs[k] <= limit) kept.push_back(planes_[k]);
    }
    if (kept.size() == planes_.size() || !hold_all(kept)) return false;
    planes_ = std::move(kept);
    return true;
  }

  void measure_misfit() {
    double freedom = -static_cast<double>(out_.layout.size());
    double cost = 0.0;
    for (const PlaneFeature& f : out_.features) {
      freedom += 3.0 * static_cast<double>(f.observations.size() - 1);
      cost += plane_cost(f, out_.state);
    }
    out_.misfit = freedom >= 2.5 ? std::sqrt(cost / freedom) : 0.0;
  }

  struct PairKey {
    int a;
    int b;
    std::size_t stop;
  };

  const RigViews& views_;
  const std::vector<std::optional<SE3>>& guess_;
  int lidars_;
  RigPlacement out_;
  std::vector<CommonPlane> planes_;
  std::vector<int> order_;  ///< In which they were placed.
  std::vector<std::pair<PairKey, PairPlacement>> tried_;
};

}  // namespace

RigPlacement place_rig(const RigViews& views, const std::vector<std::optional<SE3>>& guess_T_base_sensor) {
  return RigPlacer(views, guess_T_base_sensor).run();
}

}  // namespace rigcal
