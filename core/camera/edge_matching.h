#pragma once

#include <cmath>
#include <span>
#include <vector>

#include "core/camera/edge_views.h"

namespace rigcal {

struct MatchOptions {
  double gate_px = 2.0;   ///< Partners are looked for so far to either side.
  double scale_px = 0.4;  ///< Sigma of what is a partner.
};

/// A pixel of an image edge that a sample may be seen at, with the probability that it is.
struct EdgeMatch {
  std::uint32_t sample = 0;  ///< In CameraScene::edges.
  Eigen::Vector2d position = Eigen::Vector2d::Zero();
  Eigen::Vector2d normal = Eigen::Vector2d::UnitX();
  double weight = 0.0;  ///< All candidates of a sample and "none of them" have 1 together.
};

/// What one segment says: sums over its samples' matches.
struct SegmentFit {
  int line = 0;
  int samples = 0;
  int matched = 0;                               ///< Samples with a partner more likely than none.
  double weight = 0.0;                           ///< Sum of the matches' weights; `samples` if all are explained.
  double offset_px = 0.0;                        ///< Weighted mean; to the brighter side.
  double sigma_px = 0.0;                         ///< Expected of that mean, if the line were where it is said to be,
  double expected_px = 0.0;                      ///< and with what the line is off.
  double line_variance = 0.0;                    ///< Of the line's shift, m^2.
  double robust = 0.0;                           ///< Weight by the kernel, 0 .. 1.
  CameraVector gradient = CameraVector::Zero();  ///< Sum of w J r,
  CameraMatrix normal = CameraMatrix::Zero();    ///< and w J J^T.

  // The same with the line's own shift in the world, the third of what moves pixels.
  Vector3d shift_gradient = Vector3d::Zero();
  Matrix3d shift_normal = Matrix3d::Zero();
  Eigen::Matrix<double, camera_parameters, 3> mixed = Eigen::Matrix<double, camera_parameters, 3>::Zero();

  [[nodiscard]] double share() const { return samples > 0 ? weight / samples : 0.0; }
  /// How much of it image edges explain, 0 .. 1.
  [[nodiscard]] double explained() const { return robust * share(); }
  /// By what its sums enter the whole.
  [[nodiscard]] double information() const { return robust / (samples * sigma_px * sigma_px); }
};

/// Matches every sample of a view with all image edges that it may be (no nearest neighbour: the likelier candidates
/// weigh more, and clutter takes what fits none). `matches`, if asked for, are those that went in, segment by segment.
[[nodiscard]] std::vector<SegmentFit> match_view(const CameraScene& scene, const EdgeView& view,
                                                 const CameraAtStop& camera, const MatchOptions& options,
                                                 std::vector<EdgeMatch>* matches = nullptr);

}  // namespace rigcal
