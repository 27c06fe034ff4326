#pragma once

#include <optional>

#include "core/planes/refine.h"

namespace rigcal {

/// How flat surfaces are taken to be: what the passes so far saw of them beyond noise sets the gates of the next ones.
class SurfaceTrust {
 public:
  /// From now on a surface's distance from its plane may be an error of ranges as well, and shows no flatness.
  void distrust_noise() { trust_noise_ = false; }

  /// Gates, floor and trust of a pass that shall be tight, as the surfaces showed themselves so far.
  void set_gates(RefinePass& pass) const;

  /// What the map of a pass tells, at the state where the pass ended. Gates select what agrees: unevenness is told by
  /// a loose pass, that surfaces are flat by a tight one.
  void look_loosely(const PlaneMap& map, const RigState& state, double floor_of_map_m);
  void look_at_gates(const PlaneMap& map, const RigState& state, double floor_of_map_m);

  /// What the surfaces are not, beyond noise, m (1 sigma); 0: planes as good as their noise.
  [[nodiscard]] double unevenness_m() const;

  /// The same as it was seen, however small.
  [[nodiscard]] double seen_m() const { return seen_m_; }

 private:
  double seen_m_ = 0.0;                    ///< By the last loose pass; tight ones keep it.
  std::optional<double> seen_at_gates_m_;  ///< By the last tight one; none before the first.
  bool trust_noise_ = true;
};

/// Where surfaces are no planes, neighbouring leaves err alike (a crowned road, a range bias): many leaves of one place
/// say no more than one does. Only other stops are other places. Near surfaces, at some five metres, hold the rotation.
[[nodiscard]] Matrix6d with_unevenness(const Matrix6d& covariance, double unevenness_m, std::size_t stops);

}  // namespace rigcal
