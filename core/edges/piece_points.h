#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/edges/edge_points.h"

namespace rigcal {

/// Which points of a piece may lie on one of its faces. What bounds the face is asked of the place on the face's plane
/// where a point most likely belongs, not of the point: noise moves it along its ray, so that of what is met at a slant
/// a border in space takes the short ranges on one side and the long ones on the other.
struct FaceGate {
  Line3 line;
  double half_length_m = 0.0;  ///< Along the line from its point to either side,
  double reach_m = 0.0;        ///< and across it.
  WorldPlane own;
  double own_m = 0.0;  ///< Largest distance from the face's own plane.
  WorldPlane other;
  double border_m = 0.0;  ///< Least distance from the other face's plane, and from any third.
};

/// The points around a piece that no third plane holds. Each is looked at many times, so their places lie in arrays of
/// their own, from the piece's middle. Made once and used for one piece after the other.
class PiecePoints {
 public:
  /// Takes those within `radius_m` of the piece's middle, and some that are a little farther; none that is nearer than
  /// `apart_m` to a plane of its `others`. `noise` has an entry for each LiDAR.
  void take(const EdgePiece& piece, const EdgePoints& points, const std::vector<NoiseModel>& noise, double radius_m,
            double apart_m);

  [[nodiscard]] std::size_t size() const { return points_.size(); }
  [[nodiscard]] const EdgePoint& operator[](std::uint32_t i) const { return *points_[i]; }
  /// Of all that were taken; 0 where there are none.
  [[nodiscard]] double largest_range_m() const { return largest_range_m_; }

  /// Those that pass, in their order. Distances are good to a micrometre.
  void choose(const FaceGate& gate, std::vector<std::uint32_t>& chosen);

 private:
  void keep_marked();

  Vector3d middle_ = Vector3d::Zero();
  double largest_range_m_ = 0.0;
  std::vector<std::span<const EdgePoint>> cubes_;
  std::vector<const EdgePoint*> points_;
  std::array<std::vector<float>, 3> from_middle_;
  std::array<std::vector<float>, 3> rays_;
  std::vector<float> across_share_;  ///< Variance across the ray over that along it, met head-on.
  std::vector<float> slant_growth_;
  std::array<std::vector<float>, 3> on_plane_;  ///< Where they belong on a face, from the middle.
  std::vector<WorldPlane> others_;              ///< Third planes that may hold some.
  std::vector<std::int32_t> marks_;
};

}  // namespace rigcal
