#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/quality/open_directions.h"
#include "core/quality/stop_scatter.h"
#include "core/quality/time_halves.h"

namespace rigcal {

/// Of the score of a place without a guess: where another place has more, the two cannot be told apart.
constexpr double ambiguous_share = 0.75;

/// How much of what a LiDAR saw before a stop, and from it on, lies on planes, 0 .. 1.
struct HalfShares {
  double earlier = 0.0;
  double later = 0.0;
  int first_later_stop = 0;
};

/// Stops that were recorded as clouds, by the numbers of the first and the last that a LiDAR has.
struct StopSpan {
  int first = 0;
  int last = 0;
};

/// All that speaks for or against one LiDAR's extrinsics.
struct LidarEvidence {
  std::string name;
  std::string base_name;
  bool has_points = true;
  bool saw_too_far = false;     ///< Some of its points lie farther than cells reach.
  bool base_has_points = true;  ///< In a stop that took part, or given poses tell where it stood.
  bool took_part = true;        ///< One of the stops in which it saw something did.
  int stops = 0;                ///< Whose poses are known; 0: not told.
  double step_rad = 0.0;        ///< How far the rig turned from one of these to the next, usually,
  double step_m = 0.0;          ///< and how far it moved.
  /// Where it has as many clouds as the base, with the same gaps, but from another number on: its own and the base's.
  std::optional<StopSpan> shifted_stops;
  StopSpan base_stops;
  bool has_guess = true;
  bool found = true;               ///< The start laid it on the base's surfaces.
  bool has_assumed_steps = false;  ///< See Start.
  bool observable = true;
  bool converged = true;
  bool settled_late = false;  ///< Only passes over several grids brought it to rest.
  double last_move_m = 0.0;   ///< What the last pass over its surfaces moved it by; the last over one grid where late.
  double last_move_rad = 0.0;
  double match_score = 1.0;  ///< Share of its surfels on the base's map; runner-up: the best other pose's.
  double runner_up_score = 0.0;
  std::string stands_at;      ///< Another sensor whose initial extrinsics it fulfils instead of its own; empty: none.
  std::string same_place_as;  ///< Another sensor that stands just where it does; empty: none.
  bool guess_is_inverse = false;  ///< It stands where the inverse of its own has it.
  double from_guess_rad = 0.0;    ///< How far it is from its own.
  double from_guess_m = 0.0;
  /// Its own and the base's; of stops the numbers that users see.
  TimeHalves halves;
  TimeHalves base_halves;
  HalfShares used_halves;
  HalfShares base_used_halves;
  double used_share = 1.0;  ///< Of its cells on planes, over the same share of the base.
  Matrix6d covariance = Matrix6d::Zero();
  Matrix6d covariance_data_only = Matrix6d::Zero();
  StopScatter scatter;  ///< By how much these were widened.
  SE3 T_base_sensor;
  std::optional<HelpfulTurn> helpful_turn;  ///< For the direction in which its place is known worst.
  Vector3d frozen = Vector3d::Zero();       ///< Its own direction along which it was left where shapes laid it.
  bool is_checked = true;                   ///< Enough of what it saw could be held out.
  double hold_out = 0.0;                    ///< Normalised; 0: none.
  double hold_out_rms_m = 0.0;
  double hold_out_start_rms_m = 0.0;
};

struct Verdict {
  Status status = Status::good;
  std::vector<std::string> reasons;
};

/// What the status of a LiDAR means (docs/judging.md): good needs the 95 % bounds inside the requirement, no direction
/// that only a prior fixes, a hold-out within twice the expected noise and not worse than the start, and the runner-up
/// minimum rejected; failed is what cannot be observed, does not converge, or lies on next to nothing that others saw
/// where it has no guess, is far from it, or held-out stops disagree, too. Reasons are sentences a user can act on.
[[nodiscard]] Verdict judge_lidar(const LidarEvidence& evidence, const Requirement& require);

}  // namespace rigcal
