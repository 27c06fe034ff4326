#pragma once

#include <span>

#include "core/base/error.h"
#include "core/corner/plane_alignment.h"
#include "core/corner/ransac_planes.h"
#include "core/corner/three_planes.h"

namespace rigcal {

/// The method as published: three planes of each cloud, put in order, normals laid on each other, then the symmetric
/// point-to-plane cost. Gives T_a_b. The method wants level mounting: z is upwards in either frame. Errors: fewer than
/// three planes, planes that are nearly parallel.
[[nodiscard]] Expected<PlaneAlignment> calibrate_as_published(std::span<const Vector3d> cloud_a,
                                                              std::span<const Vector3d> cloud_b);

}  // namespace rigcal
