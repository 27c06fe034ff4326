#include "core/corner/paper_method.h"

#include <string>

namespace rigcal {
namespace {

Expected<Corner> corner_of(std::span<const Vector3d> cloud, const char* which) {
  const std::vector<FittedPlane> planes = ransac_planes(cloud, RansacOptions{});
  if (planes.size() < 3) {
    return input_error("only " + std::to_string(planes.size()) + " of the three planes of a corner found", which,
                       "show it three large flat surfaces that face different ways");
  }
  Expected<Corner> corner = make_corner({planes[0], planes[1], planes[2]}, Vector3d::UnitZ());
  if (corner) return corner;
  Error error = corner.error();
  error.where = which;
  return error;
}

}  // namespace

Expected<PlaneAlignment> calibrate_as_published(std::span<const Vector3d> cloud_a, std::span<const Vector3d> cloud_b) {
  const Expected<Corner> a = corner_of(cloud_a, "first cloud");
  if (!a) return a.error();
  const Expected<Corner> b = corner_of(cloud_b, "second cloud");
  if (!b) return b.error();
  const SE3 start = corner_alignment(*a, *b);
  std::vector<PlanePair> pairs;
  for (std::size_t k = 0; k < 3; ++k) pairs.push_back({a->planes[k], b->planes[k]});
  return align_planes(pairs, start);
}

}  // namespace rigcal
