#include "core/start/step_tree.h"

#include <algorithm>
#include <cmath>

#include "core/base/parallel.h"
#include "core/geometry/angles.h"
#include "core/start/overlap_limits.h"
#include "core/start/step_match.h"
#include "core/start/step_search.h"

namespace rigcal {
namespace {

constexpr std::size_t most_matches = 12;
// What a match needs to be believed, by what else speaks for it: that most steps are like it; that the table goes on
// the way it goes, by no more than a narrow view can follow; nothing.
constexpr double least_of_common = 0.01;
// Somebody who walked by contradicts much; what lies on what was seen to this share is believed nevertheless.
constexpr double least_share_of_common = 0.15;
constexpr double least_of_next = 0.03;
constexpr double least_alone = 0.3;
constexpr double next_rad = to_rad(75.0);
// Pairs with as much evidence tell their step clearly; of these so many are alike where steps are equal.
constexpr double clear_evidence = 0.1;
constexpr double usual_share = 0.75;
// A step like most others is taken for another one unless that has this much more evidence; one the usual way round is
// for one the other way.
constexpr double common_margin = 0.2;
constexpr double way_margin = 0.1;
// A stop that cannot be laid on the one before is laid on an earlier one, up to so many before it.
constexpr std::size_t stops_back = 3;

// The step that the evidence of all pairs adds up to most for; none where no more than half of the pairs have one like
// it that is not far behind their best, or too few of those that tell their step clearly.
std::optional<double> common_step(const std::vector<std::vector<StepMatch>>& pairs) {
  std::vector<std::vector<StepVote>> votes;
  for (const std::vector<StepMatch>& matches : pairs) {
    std::vector<StepVote>& pair = votes.emplace_back();
    for (const StepMatch& m : matches) pair.push_back({m.angle, m.score});
  }
  const std::optional<double> common = most_voted(votes);
  if (!common) return std::nullopt;
  std::size_t alike = 0;
  std::size_t clear = 0;
  std::size_t clearly_alike = 0;
  for (const std::vector<StepVote>& pair : votes) {
    const double vote = vote_for(pair, *common);
    const bool is_clear = !pair.empty() && pair.front().weight >= clear_evidence;
    const bool is_alike = vote > 0.0 && vote > 0.5 * pair.front().weight;
    alike += is_alike ? 1 : 0;
    clear += is_clear ? 1 : 0;
    clearly_alike += is_clear && is_alike ? 1 : 0;
  }
  const bool is_usual = static_cast<double>(clearly_alike) >= usual_share * static_cast<double>(clear);
  return is_usual && 2 * alike > pairs.size() ? common : std::nullopt;
}

// Which way round (1 or -1) the best matches turn, weighed by their evidence.
double usual_way(const std::vector<std::vector<StepMatch>>& pairs) {
  double sum = 0.0;
  for (const std::vector<StepMatch>& matches : pairs) {
    if (matches.empty() || std::abs(matches.front().angle) < alike_step_rad) continue;
    sum += std::copysign(std::max(0.0, matches.front().score), matches.front().angle);
  }
  return sum < 0.0 ? -1.0 : 1.0;
}

// A stop, and how it is laid on an earlier one.
struct Node {
  int stop = 0;
  StepView view;
  std::vector<StepMatch> matches;  // on the node before
  std::optional<std::size_t> parent;
  Matrix3d R_parent_this = Matrix3d::Identity();
};

class StepTree {
 public:
  StepTree(const std::vector<PatchSurfels>& patches, const Vector3d& axis,
           const std::vector<std::optional<Matrix3d>>& R_previous_this)
      : axis_(axis), R_previous_this_(R_previous_this) {
    for (const PatchSurfels& p : patches) {
      const bool is_told = !nodes_.empty() && known_step(R_previous_this, nodes_.back().stop, p.stop).has_value();
      if (p.surfels.size() >= min_surfels || is_told) nodes_.push_back({p.stop, StepView(p, axis), {}, {}});
    }
    parallel_for(nodes_.size(), 1, [&](std::size_t begin, std::size_t end) {
      for (std::size_t k = std::max<std::size_t>(begin, 1); k < end; ++k) nodes_[k].matches = matches_of(k - 1, k);
    });
    learn_steps();
    for (std::size_t k = 1; k < nodes_.size(); ++k) lay(k);
  }

  [[nodiscard]] const std::vector<Node>& nodes() const { return nodes_; }

 private:
  [[nodiscard]] std::optional<Matrix3d> told(std::size_t on, std::size_t k) const {
    return known_step(R_previous_this_, nodes_[on].stop, nodes_[k].stop);
  }

  [[nodiscard]] std::vector<StepMatch> matches_of(std::size_t on, std::size_t k) const {
    const std::optional<Matrix3d> R = told(on, k);
    if (R) return {{log_so3(*R).dot(axis_), {*R, Vector3d::Zero()}, 1.0, 1.0}};
    return nodes_[on].view.matches(nodes_[k].view.moving(), most_matches);
  }

  void learn_steps() {
    std::vector<std::vector<StepMatch>> steps;
    for (std::size_t k = 1; k < nodes_.size(); ++k) {
      // A rest that was cut in two is no step of the table.
      const std::optional<Matrix3d> R = told(k - 1, k);
      if (R && rotation_distance(*R, Matrix3d::Identity()) < alike_step_rad) continue;
      if (nodes_[k].stop == nodes_[k - 1].stop + 1) steps.push_back(nodes_[k].matches);
    }
    common_ = common_step(steps);
    way_ = usual_way(steps);
  }

  // The best of the matches that can be believed.
  [[nodiscard]] const StepMatch* best_of(std::size_t on, std::size_t k, const std::vector<StepMatch>& matches) const {
    const StepMatch* best = nullptr;
    double most = 0.0;
    for (const StepMatch& m : matches) {
      const bool is_common =
          common_ && angle_apart(m.angle, *common_ * (nodes_[k].stop - nodes_[on].stop)) < alike_step_rad;
      const double ahead = way_ * m.angle;
      const bool is_next = on + 1 == k && ahead > -alike_step_rad && ahead < next_rad;
      const bool is_usual = is_common && (m.score >= least_of_common || m.share >= least_share_of_common);
      if (!is_usual && m.score < (is_next ? least_of_next : least_alone)) continue;
      const double worth = m.score + (is_common ? common_margin : 0.0) + (is_common || is_next ? way_margin : 0.0);
      if (best != nullptr && worth <= most) continue;
      most = worth;
      best = &m;
    }
    return best;
  }

  void lay(std::size_t k) {
    Node& node = nodes_[k];
    for (std::size_t back = 1; back <= std::min(stops_back, k); ++back) {
      const std::vector<StepMatch> matches = back == 1 ? node.matches : matches_of(k - back, k);
      const StepMatch* best = best_of(k - back, k, matches);
      if (best == nullptr) continue;
      node.parent = k - back;
      node.R_parent_this = best->X.R;
      return;
    }
  }

  Vector3d axis_;
  const std::vector<std::optional<Matrix3d>>& R_previous_this_;
  std::vector<Node> nodes_;
  std::optional<double> common_;
  double way_ = 1.0;
};

// By node, which hang together: those that have the same number are laid on each other.
std::vector<std::size_t> groups_of(const std::vector<Node>& nodes) {
  std::vector<std::size_t> group;
  std::size_t count = 0;
  for (const Node& node : nodes) group.push_back(node.parent ? group[*node.parent] : count++);
  return group;
}

std::size_t largest_of(const std::vector<std::size_t>& group) {
  std::vector<std::size_t> sizes(group.size() + 1, 0);
  for (const std::size_t g : group) ++sizes[g];
  return static_cast<std::size_t>(std::max_element(sizes.begin(), sizes.end()) - sizes.begin());
}

}  // namespace

FoundTurns rotations_by_evidence(const std::vector<PatchSurfels>& base_patches, int stops, const Vector3d& axis,
                                 const std::vector<std::optional<Matrix3d>>& R_previous_this) {
  const StepTree tree(base_patches, axis, R_previous_this);
  const std::vector<Node>& nodes = tree.nodes();
  const std::vector<std::size_t> group = groups_of(nodes);
  const std::size_t largest = largest_of(group);
  const auto count = static_cast<std::size_t>(stops);
  FoundTurns out{std::vector<Matrix3d>(count, Matrix3d::Identity()), std::vector<char>(count, 0)};
  std::size_t next = 0;
  for (int j = 0; j < stops; ++j) {
    const auto sj = static_cast<std::size_t>(j);
    if (j > 0) out.R_G_base[sj] = out.R_G_base[sj - 1];
    if (next >= nodes.size() || nodes[next].stop != j) continue;
    const Node& node = nodes[next];
    if (node.parent) {
      const auto parent = static_cast<std::size_t>(nodes[*node.parent].stop);
      out.R_G_base[sj] = nearest_rotation(out.R_G_base[parent] * node.R_parent_this);
    }
    if (group[next] == largest) out.found[sj] = 1;
    ++next;
  }
  return out;
}

}  // namespace rigcal
