#pragma once

#include <span>

#include "core/base/error.h"
#include "core/corner/plane_alignment.h"
#include "core/corner/ransac_planes.h"
#include "core/corner/three_planes.h"

namespace rigcal {

struct PaperMethodOptions {
  RansacOptions ransac;
  bool refine = true;
  Vector3d up_a = Vector3d::UnitZ();  ///< Upwards in the frame of each LiDAR: the method wants level mounting.
  Vector3d up_b = Vector3d::UnitZ();
};

/// The method as published: three planes of each cloud, put in order, normals laid on each other, then the symmetric
/// point-to-plane cost. Gives T_a_b. Errors: fewer than three planes, planes that are nearly parallel.
[[nodiscard]] Expected<PlaneAlignment> calibrate_as_published(std::span<const Vector3d> cloud_a,
                                                              std::span<const Vector3d> cloud_b,
                                                              const PaperMethodOptions& options);

}  // namespace rigcal
