#pragma once

#include <array>

#include "core/base/error.h"
#include "core/corner/fitted_plane.h"

namespace rigcal {

using ThreePlanes = std::array<FittedPlane, 3>;

/// How far three directions are from lying in one plane: the smallest singular value of their matrix. 1 at right
/// angles, 0 where a combination of two is the third.
[[nodiscard]] double independence(const Vector3d& a, const Vector3d& b, const Vector3d& c);

/// Planes whose normals are less independent fix no corner to speak of: some ten degrees.
constexpr double least_independence = 0.17;

/// The point on all three planes. An Error where two are nearly parallel or all three nearly have a common direction.
[[nodiscard]] Expected<Vector3d> intersection(const ThreePlanes& planes);

/// Turns the normals so that -o is a positive combination of them, o being the planes' intersection: a rule that both
/// LiDARs follow alike as long as both stand in the same octant of the corner.
[[nodiscard]] ThreePlanes with_oriented_normals(ThreePlanes planes, const Vector3d& o);

/// Left, right, bottom: the bottom is the plane whose normal is nearest to `up` (mounting is level to within 45
/// degrees, or gravity is known), and of the others the left is the one with (n2 x n1).n3 > 0.
[[nodiscard]] ThreePlanes in_order(ThreePlanes planes, const Vector3d& up);

/// A corner ready to be compared: ordered planes with oriented normals.
struct Corner {
  ThreePlanes planes;
  Vector3d point = Vector3d::Zero();
};
/// From planes in any order; `up` is a unit vector in their frame. Errors: as `intersection`.
[[nodiscard]] Expected<Corner> make_corner(const ThreePlanes& planes, const Vector3d& up);

/// T_a_b that lays corner b on corner a: R from the normals by the Kabsch algorithm, t = o_a - R o_b.
[[nodiscard]] SE3 corner_alignment(const Corner& a, const Corner& b);

}  // namespace rigcal
