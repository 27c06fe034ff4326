#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/geometry/se3.h"
#include "core/records/records.h"

namespace rigcal {

/// Directions from a sensor on the six faces of a cube around it: (u, v) in -1 .. 1 on a face. Straight lines in space
/// are straight on a face, and the inverse depth (along the face's axis, 1/m) is linear in u and v along lines and
/// planes.
constexpr int cube_faces = 6;
struct FacePlace {
  int face = 0;
  double u = 0.0;
  double v = 0.0;
  double inverse_depth = 0.0;
};
/// p must not be zero.
[[nodiscard]] FacePlace to_face(const Vector3d& p);
[[nodiscard]] Vector3d from_face(const FacePlace& place);

/// Where a surface ends and a farther one is seen past it: the middle between two neighbouring rays.
struct DepthStep {
  float u = 0.0F;
  float v = 0.0F;
  float inverse_depth = 0.0F;  ///< Of the near surface.
  float towards_u = 0.0F;      ///< Unit, from the near to the far ray.
  float towards_v = 0.0F;
  float rise_m = 0.0F;   ///< How much farther the far surface is.
  float spacing = 0.0F;  ///< Of the rays around, in u and v.
};

/// The steps of one patch on each face. `points` are those of one sensor at one stop, in its frame. In the order of the
/// points.
[[nodiscard]] std::array<std::vector<DepthStep>, cube_faces> find_depth_steps(std::span<const Point> points);

}  // namespace rigcal
