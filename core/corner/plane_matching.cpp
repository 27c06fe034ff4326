#include "core/corner/plane_matching.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "core/corner/three_planes.h"

namespace rigcal {
namespace {

constexpr double same_angle_rad = to_rad(4.0);
constexpr std::size_t most_triples = 24;
constexpr std::size_t most_tried = 400;

using Triple = std::array<std::size_t, 3>;

// The triples that hold a pose best: large areas that face different ways.
std::vector<Triple> best_triples(const std::vector<SeenPlane>& planes) {
  std::vector<std::pair<double, Triple>> rated;
  for (std::size_t i = 0; i < planes.size(); ++i) {
    for (std::size_t j = i + 1; j < planes.size(); ++j) {
      for (std::size_t k = j + 1; k < planes.size(); ++k) {
        const double free = independence(planes[i].plane.normal, planes[j].plane.normal, planes[k].plane.normal);
        if (free < least_independence) continue;
        const double least = std::min({planes[i].area_m2, planes[j].area_m2, planes[k].area_m2});
        rated.push_back({free * std::sqrt(least), {i, j, k}});
      }
    }
  }
  std::stable_sort(rated.begin(), rated.end(), [](const auto& x, const auto& y) { return x.first > y.first; });
  std::vector<Triple> out;
  for (std::size_t i = 0; i < std::min(most_triples, rated.size()); ++i) out.push_back(rated[i].second);
  return out;
}

ThreePlanes planes_of(const std::vector<SeenPlane>& planes, const Triple& triple) {
  return {planes[triple[0]].plane, planes[triple[1]].plane, planes[triple[2]].plane};
}

bool same_angles(const ThreePlanes& a, const ThreePlanes& b) {
  for (std::size_t i = 0; i < 3; ++i) {
    const auto angle = [&](const ThreePlanes& p) {
      return std::acos(std::clamp(p[i].normal.dot(p[(i + 1) % 3].normal), -1.0, 1.0));
    };
    if (std::abs(angle(a) - angle(b)) > same_angle_rad) return false;
  }
  const auto hand = [](const ThreePlanes& p) { return p[0].normal.cross(p[1].normal).dot(p[2].normal); };
  return hand(a) * hand(b) > 0.0;
}

double matched_area(const std::vector<SeenPlane>& a, const std::vector<SeenPlane>& b, const PlaneMatches& matches) {
  double area_a = 0.0;
  double area_b = 0.0;
  for (const SeenPlane& plane : a) area_a += std::sqrt(plane.area_m2);
  for (const SeenPlane& plane : b) area_b += std::sqrt(plane.area_m2);
  double matched_a = 0.0;
  double matched_b = 0.0;
  for (const auto& [i, j] : matches) {
    matched_a += std::sqrt(a[i].area_m2);
    matched_b += std::sqrt(b[j].area_m2);
  }
  return area_a < area_b ? matched_a / area_a : matched_b / area_b;
}

bool is_known(const std::vector<AlignmentCandidate>& known, const SE3& T) {
  return std::any_of(known.begin(), known.end(), [&](const AlignmentCandidate& k) {
    return (k.T_a_b.t - T.t).norm() < 0.3 && rotation_distance(k.T_a_b.R, T.R) < to_rad(3.0);
  });
}

void sort_by_agreement(std::vector<AlignmentCandidate>& candidates) {
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const auto& x, const auto& y) { return x.agreement > y.agreement; });
}

// Three planes are laid on three in one order; the sides of the second three are chosen by `sides`.
void try_triples(const std::vector<SeenPlane>& a, const std::vector<SeenPlane>& b, const Triple& in_a, Triple in_b,
                 std::vector<AlignmentCandidate>& out) {
  const ThreePlanes planes_a = planes_of(a, in_a);
  const auto o_a = intersection(planes_a);
  if (!o_a) return;
  std::sort(in_b.begin(), in_b.end());
  do {
    for (unsigned sides = 0; sides < 8; ++sides) {
      ThreePlanes planes_b = planes_of(b, in_b);
      for (std::size_t k = 0; k < 3; ++k) {
        if ((sides >> k & 1U) != 0) planes_b[k] = planes_b[k].flipped();
      }
      if (!same_angles(planes_a, planes_b)) continue;
      const auto o_b = intersection(planes_b);
      if (!o_b) continue;
      const SE3 T = corner_alignment({planes_a, *o_a}, {planes_b, *o_b});
      if (is_known(out, T)) continue;
      const PlaneMatches matches = match_planes(a, b, T, PlaneMatchTolerance{});
      // A plane seen from its other side matches none: such places have only the three themselves.
      PlaneMatches own;
      for (std::size_t k = 0; k < 3; ++k) own.emplace_back(in_a[k], in_b[k]);
      out.push_back({T, sides == 0 ? matches : own, sides == 0 ? matched_area(a, b, matches) : 0.0});
    }
  } while (std::next_permutation(in_b.begin(), in_b.end()));
}

}  // namespace

PlaneMatches match_planes(const std::vector<SeenPlane>& a, const std::vector<SeenPlane>& b, const SE3& T,
                          const PlaneMatchTolerance& tolerance) {
  struct Rated {
    double misfit;
    std::size_t i, j;
  };
  std::vector<Rated> rated;
  for (std::size_t j = 0; j < b.size(); ++j) {
    const Vector3d normal = T.R * b[j].plane.normal;
    const Vector3d middle = T * b[j].plane.points.mean();
    for (std::size_t i = 0; i < a.size(); ++i) {
      const double angle = std::acos(std::clamp(normal.dot(a[i].plane.normal), -1.0, 1.0));
      if (angle > tolerance.angle_rad) continue;
      // Of a large and a small plane the small one's middle is the fairer lever.
      const double to_a = std::abs(a[i].plane.distance(middle));
      const double to_b = std::abs(b[j].plane.distance(T.inverse() * a[i].plane.points.mean()));
      const double distance = std::min(to_a, to_b);
      if (distance > tolerance.distance_m) continue;
      rated.push_back({distance / tolerance.distance_m + angle / tolerance.angle_rad, i, j});
    }
  }
  std::stable_sort(rated.begin(), rated.end(), [](const Rated& x, const Rated& y) { return x.misfit < y.misfit; });
  std::vector<char> used_a(a.size(), 0);
  std::vector<char> used_b(b.size(), 0);
  PlaneMatches out;
  for (const Rated& r : rated) {
    if (used_a[r.i] != 0 || used_b[r.j] != 0) continue;
    used_a[r.i] = used_b[r.j] = 1;
    out.emplace_back(r.i, r.j);
  }
  return out;
}

std::vector<PlanePair> pairs_of(const std::vector<SeenPlane>& a, const std::vector<SeenPlane>& b,
                                const PlaneMatches& matches, const SE3& T_a_b) {
  std::vector<PlanePair> pairs;
  for (const auto& [i, j] : matches) {
    const FittedPlane& of_b = b[j].plane;
    const bool turned = a[i].plane.normal.dot(T_a_b.R * of_b.normal) < 0.0;
    pairs.push_back({a[i].plane, turned ? of_b.flipped() : of_b, a[i].weight(), b[j].weight()});
  }
  return pairs;
}

double matched_independence(const std::vector<SeenPlane>& a, const PlaneMatches& matches) {
  std::vector<SeenPlane> matched;
  for (const auto& match : matches) matched.push_back(a[match.first]);
  return best_independence(matched);
}

double best_independence(const std::vector<SeenPlane>& planes) {
  double best = 0.0;
  for (std::size_t i = 0; i < planes.size(); ++i) {
    for (std::size_t j = i + 1; j < planes.size(); ++j) {
      for (std::size_t k = j + 1; k < planes.size(); ++k) {
        best = std::max(best, independence(planes[i].plane.normal, planes[j].plane.normal, planes[k].plane.normal));
      }
    }
  }
  return best;
}

std::vector<AlignmentCandidate> alignment_candidates(const std::vector<SeenPlane>& a, const std::vector<SeenPlane>& b,
                                                     std::size_t most) {
  std::vector<AlignmentCandidate> tried;
  const std::vector<Triple> triples_b = best_triples(b);
  for (const Triple& in_a : best_triples(a)) {
    for (const Triple& in_b : triples_b) {
      if (tried.size() < most_tried) try_triples(a, b, in_a, in_b, tried);
    }
  }
  sort_by_agreement(tried);
  if (tried.size() > 2 * most) tried.resize(2 * most);
  std::vector<AlignmentCandidate> out;
  for (AlignmentCandidate& c : tried) {
    c.T_a_b = align_planes(pairs_of(a, b, c.matches, c.T_a_b), c.T_a_b, 3.0).T_a_b;
    if (is_known(out, c.T_a_b)) continue;
    const PlaneMatches matches = match_planes(a, b, c.T_a_b, PlaneMatchTolerance{to_rad(3.0), 0.25});
    if (matches.size() >= 3) {
      c.matches = matches;
      c.agreement = matched_area(a, b, matches);
    }
    out.push_back(c);
    if (out.size() == most) break;
  }
  sort_by_agreement(out);
  return out;
}

}  // namespace rigcal
