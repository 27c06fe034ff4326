#pragma once

#include <vector>

#include "core/corner/plane_area.h"

namespace rigcal {

/// A plane and the share of the points near it (in its area) that lie on it.
struct PlaneShare {
  FittedPlane plane;
  double share = 0.7;
};

/// Never taken for thinner than this: no LiDAR is.
constexpr double least_sigma_m = 0.003;

/// One step of expectation and maximisation: all points are shared out between the planes, each in its area, and what
/// is none of them by their likelihoods, and everything about the planes is found anew from the points' shares. A plane
/// that loses its points has N = 0 afterwards. A point where two planes meet counts for little: nobody can tell whose
/// it is, and it has the longest lever.
[[nodiscard]] std::vector<PlaneShare> shared_out(const std::vector<Vector3d>& points,
                                                 const std::vector<PlaneShare>& planes,
                                                 const std::vector<PlaneArea>& areas);

/// Parts so large that each holds a dozen points, by the spread of all of them.
[[nodiscard]] double part_size_m(const PointCluster& points);

}  // namespace rigcal
