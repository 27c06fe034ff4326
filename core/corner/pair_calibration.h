#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/corner/plane_matching.h"
#include "core/start/shape_match.h"

namespace rigcal {

/// A LiDAR's cloud with the planes found in it.
struct PlaneView {
  PlaneCloud cloud;
  std::vector<SeenPlane> planes;
  std::optional<Vector3d> up;  ///< Unit, upwards in the LiDAR's frame, where gravity is known.
};
/// Finds the planes of a cloud; `up` is for who knows it.
[[nodiscard]] PlaneView plane_view(PlaneCloud cloud);

/// How two LiDARs lie to each other by what both saw at one moment.
struct PairPlacement {
  bool found = false;
  std::string why_not;  ///< A clause for the user where nothing was found.
  SE3 T_a_b;
  PlaneMatches matches;
  double score = 0.0;            ///< Share of what the poorer cloud saw that lies on the other's.
  double runner_up_score = 0.0;  ///< The best distinctly other place that neither gravity nor guess excludes.
  /// The best of those where three planes of b lie on other ones of a, as both see them.
  double other_order_score = 0.0;
  /// Where fewer than three planes hold it, or these are uneven: how all that was seen lies on each other.
  std::optional<ShapeMatch> by_shapes;
};

/// Whether another place may be the right one. Where a guess has excluded what is far from it, one that fits clearly
/// better is it. Without one a corner of right angles is laid on itself in three orders, of which nothing speaks
/// against any but that less of the two views overlaps: where their fields differ a wrong one overlaps as much as the
/// right one, or half as much again.
[[nodiscard]] bool is_one_of_two(const PairPlacement& placed, bool has_guess);

/// Lays b on a: by three planes and more in all orders and sides, told apart by all points, by gravity and by a rough
/// guess of T_a_b (which may be 45 degrees wrong); where three independent planes are not common to both, by the
/// largest one and all other shapes around the guess.
[[nodiscard]] PairPlacement place_pair(const PlaneView& a, const PlaneView& b, const std::optional<SE3>& guess_T_a_b);

}  // namespace rigcal
