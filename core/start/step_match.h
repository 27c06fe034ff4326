#pragma once

#include <vector>

#include "core/start/registration.h"

namespace rigcal {

/// One way in which a rig may have turned about its axis from one stop to another.
struct StepMatch {
  double angle = 0.0;     ///< About the axis, rad, right-handed.
  SE3 X;                  ///< From the base at the later stop to the base at the earlier one.
  double score = 0.0;     ///< Share of what was seen from the later stop that lies on what was seen from the earlier.
  double evidence = 0.0;  ///< See StepView::evidence; at most 1.
};

/// What the base saw from one stop, to lay on it what it saw from another one after a turn about `axis` (unit, base
/// frame). At a table both are seen from nearly the same place, so that what is not where it should be shows.
class StepView {
 public:
  StepView(const PatchSurfels& patch, const Vector3d& axis);

  /// The patch as what is to be laid on another view.
  [[nodiscard]] const MovingSurfels& moving() const { return moving_; }

  /// Share of `after` that lies on what was seen from here, less three times the share that stands before or behind
  /// what was seen there; what faces along the axis, as a floor does, fits every turn and counts for nothing. Near 0
  /// where the views have nothing in common.
  [[nodiscard]] double evidence(const MovingSurfels& after, const SE3& X) const;

  /// Share of `after` that lies on what was seen from here.
  [[nodiscard]] double score(const MovingSurfels& after, const SE3& X) const;

  /// The ways in which `after` fits, of the whole circle, distinct by 5 degrees: those of most evidence first, at most
  /// `most`, and only those that have some or lie on what was seen to a share of 0.15.
  [[nodiscard]] std::vector<StepMatch> matches(const MovingSurfels& after, std::size_t most) const;

 private:
  [[nodiscard]] bool is_contradicted(const Vector3d& p) const;

  Vector3d axis_;
  MovingSurfels moving_;
  std::vector<Surfel> surfels_;
  SurfelIndex coarse_;
  SurfelIndex fine_;
  SurfelIndex directions_;  // where they were seen, on the unit sphere
};

}  // namespace rigcal
