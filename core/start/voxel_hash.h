#pragma once

#include <cstdint>

#include "core/base/floor_of.h"
#include "core/geometry/se3.h"

namespace rigcal {

/// A cube of a grid with one corner in the origin, by its place along each axis.
struct Voxel {
  std::int64_t x, y, z;
};

/// The one that holds p, of a grid whose cubes have edges of `size_m`.
[[nodiscard]] inline Voxel voxel_of(const Vector3d& p, double size_m) {
  return {floor_of(p.x() / size_m), floor_of(p.y() / size_m), floor_of(p.z() / size_m)};
}

/// For tables whose sizes are powers of two.
[[nodiscard]] inline std::size_t hash_of(const Voxel& voxel) {
  std::uint64_t h = static_cast<std::uint64_t>(voxel.x) * 0x9E3779B97F4A7C15ULL;
  h = (h ^ static_cast<std::uint64_t>(voxel.y)) * 0xC2B2AE3D27D4EB4FULL;
  h = (h ^ static_cast<std::uint64_t>(voxel.z)) * 0x165667B19E3779F9ULL;
  return static_cast<std::size_t>(h >> 24);
}

}  // namespace rigcal
