#pragma once

#include <span>
#include <vector>

#include "core/camera/joint_histogram.h"
#include "core/camera/sightings.h"
#include "core/camera/smooth_image.h"

namespace rigcal {

/// The normalised information distance between what the LiDARs know of the surfaces that a camera sees and the grey
/// values that it sees there, as a function of where the camera is.
class InformationCost {
 public:
  /// `sightings` and `images` (one a view) must outlive it.
  InformationCost(const CameraModel& model, std::span<const Sighting> sightings, std::span<const SmoothImage> images)
      : model_(model), sightings_(sightings), images_(images) {}

  struct Value {
    double distance = 1.0;
    double seen = 0.0;  ///< Sightings that fell into the images.
  };
  [[nodiscard]] Value value(const SE3& T_base_camera) const;
  /// Of fewer sightings in the images it says nothing.
  static constexpr double kLeastSeen = 1000.0;

  /// With the derivative by xi in T_base_camera exp(xi), xi = [rotation; translation].
  struct Derivatives {
    double value = 1.0;  ///< The distance.
    double seen = 0.0;
    Vector6d gradient = Vector6d::Zero();
    /// Mean of the squared slopes of the grey value by xi: the shape of the cost's curvature, not its size.
    Matrix6d shape = Matrix6d::Zero();
  };
  [[nodiscard]] Derivatives derivatives(const SE3& T_base_camera) const;

  /// Scatter of the gradient that its parts show: sum of g g^T over the tiles of all images, with g what the sightings
  /// in a tile add to the gradient. Neighbours err together, tiles hardly do.
  [[nodiscard]] Matrix6d gradient_scatter(const SE3& T_base_camera) const;

 private:
  struct Slope;
  [[nodiscard]] JointHistogram histogram(const SE3& T_camera_base, std::vector<Slope>& slopes) const;
  static Vector6d gradient_of(const Slope& slope, const std::vector<float>& by_count);

  const CameraModel& model_;
  std::span<const Sighting> sightings_;
  std::span<const SmoothImage> images_;
};

}  // namespace rigcal
