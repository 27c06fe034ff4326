#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace rigcal {

/// The cube of edge 1 / `per_m` that holds p, as one number; cubes within 2^20 edges of the origin have different ones.
[[nodiscard]] std::uint64_t cube_key(const Eigen::Vector3f& p, double per_m);

/// The corner of a key's cube at which all coordinates are least, in edges.
[[nodiscard]] Eigen::Vector3d cube_corner(std::uint64_t key);

}  // namespace rigcal
