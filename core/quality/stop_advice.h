#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/quality/lidar_quality.h"
#include "core/quality/turning_axis.h"

namespace rigcal {

/// A flat piece of a surface that one LiDAR saw at one stop, in its frame.
struct SeenSurface {
  int lidar = 0;
  int stop = 0;
  Vector3d mean = Vector3d::Zero();
  Vector3d normal = Vector3d::UnitZ();  ///< Unit, towards the LiDAR.
  double variance = 0.0;                ///< Of its mean along the normal, m^2.
};

/// What is known so far.
struct StopAdviceInput {
  const RigState& state;
  const std::vector<char>& stop_known;
  const std::vector<char>& lidar_known;  ///< Roughly, at least.
  int base = 0;
  const std::vector<SeenSurface>& surfaces;
  const std::vector<Matrix6d>& covariances;  ///< Of each LiDAR; zero where there is none.
  Requirement goal;
  TurningAxis axis;
};

/// 95 % bounds of the LiDAR that would be least sure, in parts of the goal the worse of the two.
struct PredictedBounds {
  int lidar = 0;
  double translation_m = 0.0;
  double rotation_rad = 0.0;
  double of_goal = 0.0;  ///< 1: the goal is just reached.
};

/// One more stop after a turn from where the rig stands.
struct TurnCandidate {
  double angle_rad = 0.0;
  PredictedBounds after;
};

/// One more flat surface of about a square metre, seen at all stops at which a LiDAR looks there. In the base frame at
/// the last stop.
struct SurfaceCandidate {
  Vector3d place = Vector3d::Zero();
  Vector3d normal = Vector3d::UnitZ();  ///< Unit, towards the rig.
  PredictedBounds after;
};

struct StopAdvice {
  PredictedBounds now;
  std::vector<TurnCandidate> turns;  ///< By angle.
  std::size_t best_turn = 0;
  std::optional<SurfaceCandidate> surface;  ///< Nothing where no place is in the view of the LiDAR that is least sure.
};

/// Which turn of the table, or which further surface, would shrink the largest sigma most: the information of all known
/// poses and extrinsics on the surfaces seen so far, with what one more stop at each turn would add (a LiDAR sees again
/// what lies where it has seen something before), poses and surfaces eliminated. Only ratios are taken from this model;
/// they scale the covariances given. Nothing while fewer than two LiDARs are known.
[[nodiscard]] std::optional<StopAdvice> advise_stop(const StopAdviceInput& input);

/// The advice as one sentence for the person at the table. `names`: of the LiDARs.
[[nodiscard]] std::string advice_text(const StopAdvice& advice, const std::vector<std::string>& names);

}  // namespace rigcal
