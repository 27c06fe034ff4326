#pragma once

#include <optional>
#include <vector>

#include "core/start/registration.h"

namespace rigcal {

/// Steps of a table that differ by less are alike: turned by hand it hits its marks to some degrees.
constexpr double alike_step_rad = to_rad(6.0);

/// By how much (rad, right-handed) `R` turns about `axis` (unit); nothing where it turns about another one, by more
/// than the 3 degrees to which axis and table are known.
[[nodiscard]] std::optional<double> angle_about(const Vector3d& axis, const Matrix3d& R);
/// Whether a base lies farther off after a move `X` (T_before_after, m) than a turn of its table can carry it, which it
/// stands on within 0.6 m of the axis.
[[nodiscard]] bool has_slid(const SE3& X);

/// A step that a pair of stops may stand apart by, and what speaks for it.
struct StepVote {
  double angle = 0.0;  ///< About the axis, rad.
  double weight = 0.0;
};

/// What a pair says for a step of `angle_rad`: the most weight of those alike; the nearer ones count a little more.
[[nodiscard]] double vote_for(const std::vector<StepVote>& pair, double angle_rad);
/// The step, in whole degrees, that the votes of all pairs add up to most for, rad; nothing without any.
[[nodiscard]] std::optional<double> most_voted(const std::vector<std::vector<StepVote>>& pairs);

/// The turn from stop `from` to the later stop `to`, where all turns between are known; `R_previous_this` may be empty.
[[nodiscard]] std::optional<Matrix3d> known_step(const std::vector<std::optional<Matrix3d>>& R_previous_this, int from,
                                                 int to);

/// How the rig is turned at each stop (R_G_base, the first is the identity) where no gyro was there. Each patch is
/// turned about `axis` (unit, base frame) through the full circle and laid on the one before it; most steps of a table
/// are alike, so that what most of them agree on decides where one alone is ambiguous. `base_patches` in the order of
/// stops, at most one for each; a stop without a patch repeats the rotation before it. `scores`: of the match that was
/// chosen (0: none, the common step stands in; 1 for the first patch, for stops without one, and for steps that
/// `R_previous_this` knows: empty, or one for each stop).
[[nodiscard]] std::vector<Matrix3d> rotations_from_search(const std::vector<PatchSurfels>& base_patches, int stops,
                                                          const Vector3d& axis,
                                                          const std::vector<std::optional<Matrix3d>>& R_previous_this,
                                                          std::vector<double>& scores);

}  // namespace rigcal
