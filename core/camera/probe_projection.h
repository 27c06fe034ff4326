#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/geometry/se3.h"
#include "core/rig/camera_model.h"

namespace rigcal {

/// Points of edges in a camera's frame and a second one a little along each edge, one array for each coordinate: they
/// are projected together, from one pose of the camera after the other.
class ProbePoints {
 public:
  void add(const Vector3d& p, const Vector3d& beside);
  [[nodiscard]] std::size_t size() const { return p_[0].size(); }

  /// Where the points lie in the image, and the direction of their edges there, in pixels.
  struct Pixels {
    std::vector<float> x;  ///< Far outside of any image where no ray reaches the point or the one beside it.
    std::vector<float> y;
    std::vector<float> along_x;
    std::vector<float> along_y;
  };
  /// Those from `begin` up to `end` from a camera that stands at `T` in the points' frame. Good to a thousandth of a
  /// pixel.
  void project(const CameraModel& model, const SE3& T, std::size_t begin, std::size_t end, Pixels& pixels) const;

 private:
  void project_any(const CameraModel& model, const SE3& T, std::size_t begin, std::size_t end, Pixels& pixels) const;

  std::array<std::vector<float>, 3> p_;
  std::array<std::vector<float>, 3> beside_;
};

}  // namespace rigcal
