#pragma once

#include <vector>

#include "core/start/registration.h"

namespace rigcal {

/// One way in which a rig may have turned about its axis from one stop to another.
struct StepMatch {
  double angle = 0.0;  ///< About the axis, rad, right-handed.
  SE3 X;               ///< T_earlier_later of the base, m.
  double score = 0.0;  ///< By StepView::evidence; at most 1.
  double share = 0.0;  ///< By StepView::share.
};

/// What the base saw from one stop, to lay on it what it saw from another one after a turn about `axis` (unit, base
/// frame). At a table both are seen from nearly the same place, so that what is not where it should be shows.
class StepView {
 public:
  StepView(const PatchSurfels& patch, const Vector3d& axis);

  /// The patch as what is to be laid on another view.
  [[nodiscard]] const MovingSurfels& moving() const { return moving_; }

  /// Share of `after`, moved by `X` (T_here_after, m), that lies on what was seen from here, less three times the share
  /// that stands before or behind what was seen there; what faces along the axis, as a floor does, fits every turn and
  /// counts for nothing. Near 0 where the views have nothing in common.
  [[nodiscard]] double evidence(const MovingSurfels& after, const SE3& X) const;

  /// Share of `after`, moved by `X`, that lies on what was seen from here.
  [[nodiscard]] double share(const MovingSurfels& after, const SE3& X) const;

  /// The ways in which `after` fits, of the whole circle, distinct by 5 degrees: the best first, at most
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
