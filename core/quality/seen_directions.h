#pragma once

#include <array>

#include "core/geometry/se3.h"

namespace rigcal {

/// Where a LiDAR has seen something so far, as directions in its frame: about its field of view, whatever its model.
class SeenDirections {
 public:
  /// Marks the direction of p (sensor frame) and those within some six degrees.
  void add(const Vector3d& p);
  [[nodiscard]] bool contains(const Vector3d& p) const;

 private:
  static constexpr int rows = 30;  ///< Of six degrees from -90 to 90 of elevation,
  static constexpr int columns = 60;
  static std::array<int, 2> place(const Vector3d& p);

  std::array<bool, static_cast<std::size_t>(rows) * columns> is_seen_{};
};

}  // namespace rigcal
