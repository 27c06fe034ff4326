#include "core/voxel/cube_key.h"

#include "core/base/floor_of.h"
#include "core/base/packed_cube.h"

namespace rigcal {

std::uint64_t cube_key(const Eigen::Vector3f& p, double per_m) {
  return packed_cube(floor_of(p.x() * per_m), floor_of(p.y() * per_m), floor_of(p.z() * per_m));
}

Eigen::Vector3d cube_corner(std::uint64_t key) {
  const auto part = [&](int axis) { return static_cast<double>(index_of_packed(key, axis)); };
  return {part(0), part(1), part(2)};
}

}  // namespace rigcal
