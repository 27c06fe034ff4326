#include "core/pipeline/stop_groups.h"

#include <algorithm>
#include <utility>

#include "core/base/median.h"
#include "core/base/text.h"
#include "core/geometry/symmetric_eigen.h"

namespace rigcal {
namespace {

// Of the turns that a group's planes hold, in points, common ones with another group hold this share at least.
// Simulated recordings that are right have 0.2 and more wherever they are cut, the seams of wrong ones 0.06 at most.
constexpr double least_share = 0.1;
// Neighbours that have as much in common need no comparison with what hangs together most.
constexpr double enough_share = 0.3;
// No group is asked for more than the usual stop holds, since a seam grows no longer with what lies beyond it (nor do
// chance partners with the number of stops: a plane counts as the stop has it that saw most of it); nor for less than
// this share of it, where a stop holds little because nobody else saw what it saw.
constexpr double least_of_usual = 0.25;

struct Group {
  std::vector<std::size_t> stops;
  std::vector<double> points;  // of each plane, at the stop that saw most of it
  double held = 0.0;
};

class Grouping {
 public:
  Grouping(const std::vector<char>& used, const PlaneMap& map) {
    for (const PlaneFeature& feature : map.features) {
      if (!feature.merged) planes_.push_back(&feature);
    }
    std::vector<std::size_t> group_of(used.size());
    for (std::size_t j = 0; j < used.size(); ++j) {
      if (!used[j]) continue;
      group_of[j] = groups_.size();
      groups_.push_back({{j}, std::vector<double>(planes_.size(), 0.0), 0.0});
    }
    for (std::size_t k = 0; k < planes_.size(); ++k) {
      for (const PlaneObservation& o : planes_[k]->observations) {
        const auto j = static_cast<std::size_t>(o.stop);
        if (used[j]) groups_[group_of[j]].points[k] += o.N;  // by several LiDARs
      }
    }
    std::vector<double> held;
    for (Group& group : groups_) {
      group.held = turns_held_by(group.points);
      held.push_back(group.held);
    }
    if (!held.empty()) usual_ = median(std::move(held));
  }

  std::vector<std::vector<std::size_t>> run(const std::vector<char>& told) {
    join_where([&](const Group& a, const Group& b) {
      const auto next = told.begin() + static_cast<std::ptrdiff_t>(a.stops.back()) + 1;
      const auto end = told.begin() + static_cast<std::ptrdiff_t>(b.stops.front()) + 1;
      return std::all_of(next, end, [](char is_told) { return is_told != 0; });
    });
    join_where([&](const Group& a, const Group& b) { return common_share(a, b) >= enough_share; });
    join_best();
    std::vector<std::vector<std::size_t>> out;
    for (const Group& group : groups_) out.push_back(group.stops);
    for (auto& stops : out) std::sort(stops.begin(), stops.end());
    std::stable_sort(out.begin(), out.end(), [](const auto& a, const auto& b) { return a.size() > b.size(); });
    return out;
  }

 private:
  // A plane holds turns about all axes but its normal: in points, about the axis that is held least.
  [[nodiscard]] double turns_held_by(const std::vector<double>& points) const {
    Matrix3d held = Matrix3d::Zero();
    for (std::size_t k = 0; k < points.size(); ++k) {
      if (points[k] <= 0.0) continue;
      const Vector3d& n = planes_[k]->normal_G;
      held += points[k] * (Matrix3d::Identity() - n * n.transpose());
    }
    return symmetric_eigen(held).values.x();
  }

  [[nodiscard]] double common_share(const Group& a, const Group& b) const {
    std::vector<double> both(planes_.size());
    for (std::size_t k = 0; k < both.size(); ++k) both[k] = std::min(a.points[k], b.points[k]);
    const double asked = std::clamp(std::min(a.held, b.held), least_of_usual * usual_, usual_);
    return asked > 0.0 ? turns_held_by(both) / asked : 1.0;
  }

  void join(std::size_t a, std::size_t b) {
    Group& into = groups_[a];
    into.stops.insert(into.stops.end(), groups_[b].stops.begin(), groups_[b].stops.end());
    for (std::size_t k = 0; k < into.points.size(); ++k) {
      into.points[k] = std::max(into.points[k], groups_[b].points[k]);
    }
    into.held = turns_held_by(into.points);
    groups_.erase(groups_.begin() + static_cast<std::ptrdiff_t>(b));
  }

  // Neighbours, in the order of stops.
  template <class Hang>
  void join_where(const Hang& hang) {
    for (std::size_t a = 0; a + 1 < groups_.size();) {
      if (hang(groups_[a], groups_[a + 1])) {
        join(a, a + 1);
      } else {
        ++a;
      }
    }
  }

  // Whichever hang together most, until none do enough.
  void join_best() {
    std::vector<std::vector<double>> shares;
    for (std::size_t a = 0; a < groups_.size(); ++a) {
      shares.emplace_back(groups_.size(), 0.0);
      for (std::size_t b = 0; b < a; ++b) shares[a][b] = common_share(groups_[a], groups_[b]);
    }
    while (groups_.size() > 1) {
      std::size_t best_a = 1;
      std::size_t best_b = 0;
      for (std::size_t a = 1; a < groups_.size(); ++a) {
        for (std::size_t b = 0; b < a; ++b) {
          if (shares[a][b] <= shares[best_a][best_b]) continue;
          best_a = a;
          best_b = b;
        }
      }
      if (shares[best_a][best_b] < least_share) return;
      join(best_b, best_a);
      shares.erase(shares.begin() + static_cast<std::ptrdiff_t>(best_a));
      for (auto& row : shares) row.erase(row.begin() + static_cast<std::ptrdiff_t>(best_a));
      for (std::size_t other = 0; other < groups_.size(); ++other) {
        if (other == best_b) continue;
        shares[std::max(other, best_b)][std::min(other, best_b)] = common_share(groups_[other], groups_[best_b]);
      }
    }
  }

  std::vector<const PlaneFeature*> planes_;
  std::vector<Group> groups_;
  double usual_ = 0.0;  // what the usual stop holds
};

}  // namespace

std::vector<std::vector<std::size_t>> stop_groups(const std::vector<char>& used, const std::vector<char>& told,
                                                  const PlaneMap& map) {
  return Grouping(used, map).run(told);
}

std::string apart_words(const std::vector<int>& numbers) {
  std::vector<std::string> runs;
  for (std::size_t begin = 0; begin < numbers.size();) {
    std::size_t end = begin + 1;
    while (end < numbers.size() && numbers[end] == numbers[end - 1] + 1) ++end;
    runs.push_back(std::to_string(numbers[begin]));
    if (end > begin + 1) runs.back() += (end == begin + 2 ? ", " : " to ") + std::to_string(numbers[end - 1]);
    begin = end;
  }
  const bool one = numbers.size() == 1;
  return (one ? "stop " : "stops ") + joined(runs, ", ") + (one ? " is" : " are") +
         " left out: too little of what was seen from there was seen from the other stops, to tell how the rig was "
         "turned between them; turn by smaller steps, or record more stops between";
}

}  // namespace rigcal
