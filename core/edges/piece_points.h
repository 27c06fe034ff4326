#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/edges/edge_points.h"

namespace rigcal {

/// Which points of a piece may lie on one of its faces.
struct FaceGate {
  Line3 line;
  double half_length_m = 0.0;  ///< Along the line from its point to either side,
  double reach_m = 0.0;        ///< and across it.
  WorldPlane own;
  double own_m = 0.0;  ///< Largest distance from the face's own plane,
  WorldPlane other;
  double other_m = 0.0;  ///< and least from the other face's.
};

/// The points around a piece that no third plane holds. Each is looked at many times, so their places lie in arrays of
/// their own, from the piece's middle. Made once and used for one piece after the other.
class PiecePoints {
 public:
  /// Takes those within `radius_m` of the piece's middle, and some that are a little farther; none that is nearer than
  /// `apart_m` to a plane of its `others`.
  void take(const EdgePiece& piece, const EdgePoints& points, double radius_m, double apart_m);

  [[nodiscard]] std::size_t size() const { return points_.size(); }
  [[nodiscard]] const EdgePoint& operator[](std::uint32_t i) const { return *points_[i]; }
  /// Of all that were taken; 0 where there are none.
  [[nodiscard]] double largest_range_m() const { return largest_range_m_; }

  /// Those that pass, in their order. Distances are good to a micrometre.
  void choose(const FaceGate& gate, std::vector<std::uint32_t>& chosen);

 private:
  void keep_unmarked();

  Vector3d middle_ = Vector3d::Zero();
  double largest_range_m_ = 0.0;
  std::vector<std::span<const EdgePoint>> cubes_;
  std::vector<const EdgePoint*> points_;
  std::array<std::vector<float>, 3> from_middle_;
  std::vector<std::int32_t> marks_;
};

}  // namespace rigcal
