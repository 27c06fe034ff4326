#include "core/start/coarse_search.h"

#include <algorithm>
#include <numeric>

#include "core/base/best_apart.h"
#include "core/base/parallel.h"

namespace rigcal {
namespace {

// Every pose is first tried with every so many-th surfel; so many times as many as are wanted, the best of these, then
// with all.
constexpr std::size_t first_stride = 4;
constexpr std::size_t tried_for_each = 8;

// A pose whose surfels are asked for one part after the other. The score is the number that matched.
struct Asked {
  SE3 X;
  double score = 0.0;
  std::size_t matched = 0;
  std::size_t asked = 0;
  bool given_up = false;
};

class CoarseSearch {
 public:
  CoarseSearch(const SurfelIndex& index, const MovingSurfels& moving, const SurfelMatchTolerance& tolerance)
      : index_(index), moving_(moving), tolerance_(tolerance) {
    for (std::size_t first = 0; first < first_stride; ++first) {
      for (std::size_t i = first; i < moving.items.size(); i += first_stride) order_.push_back(i);
    }
  }

  template <class Near>
  std::vector<Asked> best(const std::vector<SE3>& poses, std::size_t most, const Near& near) const {
    const std::size_t all_items = order_.size();
    std::vector<Asked> all;
    all.reserve(poses.size());
    for (const SE3& X : poses) all.push_back({X});
    for_each(all, [&](Asked& pose) { ask(pose, (all_items + first_stride - 1) / first_stride, 0); });
    // Among the first best ones are some that stand apart: what cannot reach the last of these is given up.
    std::vector<Asked> first = best_ones(all, std::min(all.size(), tried_for_each * most));
    for_each(first, [&](Asked& pose) { ask(pose, all_items, 0); });
    first = best_apart(std::move(first), most, near);
    const std::size_t least = first.empty() || first.size() < most ? 0 : first.back().matched;
    for_each(all, [&](Asked& pose) { ask(pose, all_items, least); });
    std::vector<Asked> out = best_apart(all, most, near);
    // A better one may stand near several of the first, and then fewer are left: all have to be asked to the end.
    if (out.empty() || (out.size() == most && out.back().matched >= least)) return out;
    for_each(all, [&](Asked& pose) {
      pose.given_up = false;
      ask(pose, all_items, 0);
    });
    return best_apart(std::move(all), most, near);
  }

 private:
  template <class F>
  static void for_each(std::vector<Asked>& poses, const F& f) {
    parallel_for(poses.size(), 16, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) f(poses[i]);
    });
  }

  static std::vector<Asked> best_ones(const std::vector<Asked>& all, std::size_t count) {
    std::vector<std::size_t> order(all.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::partial_sort(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(count), order.end(),
                      [&](std::size_t a, std::size_t b) {
                        return all[a].matched != all[b].matched ? all[a].matched > all[b].matched : a < b;
                      });
    std::vector<Asked> out;
    for (std::size_t k = 0; k < count; ++k) out.push_back(all[order[k]]);
    return out;
  }

  // Until so many surfels were asked for, or fewer than `least` can match any more.
  void ask(Asked& pose, std::size_t until, std::size_t least) const {
    if (pose.asked >= until || pose.given_up) return;
    const std::vector<SE3> placed = placed_by(moving_, pose.X);
    for (; pose.asked < until; ++pose.asked) {
      pose.given_up = pose.matched + (order_.size() - pose.asked) < least;
      if (pose.given_up) break;
      const auto& item = moving_.items[order_[pose.asked]];
      const SE3& T = placed[static_cast<std::size_t>(item.place)];
      pose.matched +=
          index_.contains(T * item.mean, T.R * item.normal, tolerance_.min_cosine, tolerance_.max_plane_distance_m) ? 1
                                                                                                                    : 0;
    }
    pose.score = static_cast<double>(pose.matched);
  }

  const SurfelIndex& index_;
  const MovingSurfels& moving_;
  const SurfelMatchTolerance& tolerance_;
  std::vector<std::size_t> order_;  // in which the surfels are asked for: evenly over all at any time
};

}  // namespace

std::vector<SE3> placed_by(const MovingSurfels& moving, const SE3& X) {
  std::vector<SE3> out;
  out.reserve(moving.places.size());
  for (const SE3& place : moving.places) out.push_back(place * X);
  return out;
}

std::vector<ScoredPose> best_matches(const SurfelIndex& index, const MovingSurfels& moving,
                                     const std::vector<SE3>& poses, const SurfelMatchTolerance& tolerance,
                                     std::size_t most, const std::function<bool(const SE3&, const SE3&)>& near) {
  const CoarseSearch search(index, moving, tolerance);
  const auto count = static_cast<double>(std::max<std::size_t>(1, moving.items.size()));
  std::vector<ScoredPose> out;
  for (const Asked& pose : search.best(poses, most, [&](const Asked&a, const Asked&b) { return near(a.X, b.X); })) {
    out.push_back({pose.X, static_cast<double>(pose.matched) / count});
  }
  return out;
}

}  // namespace rigcal
