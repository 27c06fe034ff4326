#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include "core/corner/plane_alignment.h"
#include "core/corner/seen_planes.h"

namespace rigcal {

/// Which plane of a (first) is which of b (second).
using PlaneMatches = std::vector<std::pair<std::size_t, std::size_t>>;

/// How alike two planes must be to be taken for one.
struct PlaneMatchTolerance {
  double angle_rad = to_rad(5.0);
  double distance_m = 0.4;  ///< Of the middle of each from the other.
};

/// The planes that are one at T_a_b, each at most once, the best agreeing first. Both normals are towards their
/// sensors, which stand on the same side of what both see.
[[nodiscard]] PlaneMatches match_planes(const std::vector<SeenPlane>& a, const std::vector<SeenPlane>& b,
                                        const SE3& T_a_b, const PlaneMatchTolerance& tolerance);

/// The pairs with weights and b's normals facing as a's do at T_a_b, for `align_planes`.
[[nodiscard]] std::vector<PlanePair> pairs_of(const std::vector<SeenPlane>& a, const std::vector<SeenPlane>& b,
                                              const PlaneMatches& matches, const SE3& T_a_b);

/// `independence` of the best three normals; 0 for fewer than three planes.
[[nodiscard]] double best_independence(const std::vector<SeenPlane>& planes);
/// The same of those planes of a that are matched.
[[nodiscard]] double matched_independence(const std::vector<SeenPlane>& a, const PlaneMatches& matches);

/// One way to lay b on a.
struct AlignmentCandidate {
  SE3 T_a_b;
  PlaneMatches matches;
  double agreement = 0.0;  ///< Share of the planes' area (of the cloud with less) that is matched.
};

/// All ways to lay b on a by three planes of each, in any order and with any sides that make a rotation, as far as the
/// angles between the planes agree; refined by all planes that then match, and each place once. Best agreement first,
/// at most `most`.
[[nodiscard]] std::vector<AlignmentCandidate> alignment_candidates(const std::vector<SeenPlane>& a,
                                                                   const std::vector<SeenPlane>& b, std::size_t most);

}  // namespace rigcal
