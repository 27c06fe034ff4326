#pragma once

#include "apps/experiment/targetless/icp.h"
#include "apps/experiment/targetless/simulated_set.h"

namespace rigcal::targetless {

/// The extrinsics' errors of one trial after each iteration of one method; the first are those of the guess.
struct Trial {
  std::vector<RigError> errors;
  std::vector<std::optional<SE3>> T_base_sensor;  ///< At the end; nothing of a LiDAR that failed.
  double seconds = 0.0;                           ///< Start to joint solution, the verdict apart.

  /// Whether every LiDAR is within 2 cm and 0.2 degrees after so many iterations (the last: where there are fewer), and
  /// none failed at the end.
  [[nodiscard]] bool is_right(std::size_t iteration) const;
  [[nodiscard]] const RigError& after(std::size_t iteration) const;
  /// The iteration from which on it stays right; nothing where it is not at last.
  [[nodiscard]] std::optional<int> right_from() const;
};

/// What both methods are tried on: a set, and its points in k-d trees. The set has none any more.
struct Ground {
  SimulatedSet set;
  PairwiseIcp icp;
};

struct GroundOptions {
  std::vector<std::string> scenes{"courtyard", "room"};
  std::uint64_t seed = 1;
  int points = 20000;
  int stops = 20;
};

/// Errors: the scene.
[[nodiscard]] Expected<Ground> make_ground(const SetOptions& options, const sim::Scene& scene);

/// One for each scene. Errors: cancelled.
[[nodiscard]] Expected<std::vector<Ground>> make_grounds(const GroundOptions& options, const RunContext& context);

/// `calibrate_lidars` with the set's rough poses and these guesses. Iteration 1 is the start (surfels searched for
/// around the guess and laid on each other), each other one a map of adaptive voxels built anew and solved.
[[nodiscard]] Expected<Trial> try_ours(const SimulatedSet& set, const std::vector<SE3>& guess,
                                       const RunContext& context);

/// `run_icp` from the same.
[[nodiscard]] Trial try_icp(Ground& ground, const std::vector<SE3>& guess, int iterations, bool stop_when_settled,
                            const RunContext& context);

}  // namespace rigcal::targetless
