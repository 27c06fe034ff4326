#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>

#include "core/rig/rig.h"

namespace rigcal {

/// fx fy cx cy and up to five distortion coefficients in the order of CameraIntrinsics.
constexpr int intrinsics_count = 9;

/// First derivatives of a pixel.
struct PixelDerivatives {
  Eigen::Matrix<double, 2, 3> by_point;                      ///< pixel / m, in the camera's frame.
  Eigen::Matrix<double, 2, intrinsics_count> by_intrinsics;  ///< fx fy cx cy d0 .. d4; zero where a model has fewer.
};

/// Projects points of the optical frame (x right, y down, z forward) to pixels and back. radtan is the model of Brown
/// (1966) as OpenCV writes it; equidistant that of Kannala and Brandt (2006), also beyond 90 degrees from the axis.
class CameraModel {
 public:
  explicit CameraModel(const CameraIntrinsics& intrinsics);

  /// The pixel that sees `p_camera` (metres), inside the image or not. Nothing for points that no ray reaches: behind a
  /// radtan camera, and farther from the axis than `max_angle_rad`, where the distortion would fold back.
  [[nodiscard]] std::optional<Eigen::Vector2d> project(const Vector3d& p_camera) const;
  [[nodiscard]] std::optional<Eigen::Vector2d> project(const Vector3d& p_camera, PixelDerivatives& derivatives) const;
  /// The same with the derivative by the point alone, which is quicker.
  [[nodiscard]] std::optional<Eigen::Vector2d> project(const Vector3d& p_camera,
                                                       Eigen::Matrix<double, 2, 3>& by_point) const;

  /// The unit vector that a pixel sees; nothing outside of what `project` reaches.
  [[nodiscard]] std::optional<Vector3d> ray(const Eigen::Vector2d& pixel) const;

  /// Whether a pixel lies in the image, at least `margin` pixels from the centres of its outermost pixels.
  [[nodiscard]] bool contains(const Eigen::Vector2d& pixel, double margin = 0.0) const;

  /// Cosine of an angle from the optical axis that nothing in the image exceeds, with a margin of a twentieth of its
  /// size: sorts out quickly what lies beside or behind. -1 where some corner has no ray.
  [[nodiscard]] double widest_cos() const;

  /// Largest angle from the optical axis that is projected.
  [[nodiscard]] double max_angle_rad() const { return max_angle_rad_; }
  [[nodiscard]] const CameraIntrinsics& intrinsics() const { return intrinsics_; }

 private:
  using Matrix23 = Eigen::Matrix<double, 2, 3>;
  struct Distorted;
  enum class Wanted { value, by_point, all };

  template <Wanted wanted>
  [[nodiscard]] bool distort(const Vector3d& p_camera, Distorted& out) const;
  template <Wanted wanted>
  void distort_wide(const Vector3d& p_camera, double r, double theta, Distorted& out) const;
  [[nodiscard]] std::optional<Vector3d> undistort_radtan(const Eigen::Vector2d& distorted) const;
  [[nodiscard]] std::optional<Vector3d> undistort_equidistant(const Eigen::Vector2d& distorted) const;

  CameraIntrinsics intrinsics_;
  std::array<double, 5> d_{};
  double max_angle_rad_ = 0.0;
  double max_tangent2_ = 0.0;  ///< Of a radtan camera: the square of the largest angle's tangent.
};

}  // namespace rigcal
