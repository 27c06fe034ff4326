#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "core/geometry/se3.h"
#include "core/rig/rig.h"

namespace rigcal {

/// The checkerboard of a rig file. Its frame has its origin in the middle of the plate, x along the columns, y along
/// the rows, z through the plate away from who looks at the squares (as OpenCV has it). Lengths are in metres, or in
/// the unit of `square` where there are only cameras.
class BoardModel {
 public:
  /// Where the settings give no size, the plate ends with the outermost squares.
  explicit BoardModel(const BoardSettings& settings);

  [[nodiscard]] int columns() const { return columns_; }  ///< Of inner corners.
  [[nodiscard]] int rows() const { return rows_; }
  [[nodiscard]] int corner_count() const { return columns_ * rows_; }
  [[nodiscard]] double square() const { return square_; }
  [[nodiscard]] const Eigen::Vector2d& size() const { return size_; }      ///< Of the plate.
  [[nodiscard]] const Eigen::Vector2d& offset() const { return offset_; }  ///< Of the pattern's middle.

  /// Markers in the bright squares (ChArUco): the dictionary's number (marker_dictionary), and the length of a side.
  [[nodiscard]] bool has_markers() const { return dictionary_ >= 0; }
  [[nodiscard]] int dictionary() const { return dictionary_; }
  [[nodiscard]] double marker() const { return marker_; }

  /// Inner corner `id` = row * columns + column.
  [[nodiscard]] Vector3d corner(int id) const { return lattice(id % columns_, id / columns_); }
  /// Where squares meet, also beyond the inner corners.
  [[nodiscard]] Vector3d lattice(double column, double row) const;
  /// The nearest inner corner to a point of the lattice; -1 where it is none.
  [[nodiscard]] int id_at(const Vector3d& p) const;
  /// Whether the square that a point of the board lies on has the colour of the first one; nothing beside the pattern
  /// and within `margin` (share of a square) of its lines: 0.
  [[nodiscard]] int colour_at(double x, double y, double margin) const;

  /// The plate's corners in order round it.
  [[nodiscard]] std::array<Vector3d, 4> plate_corners() const;

  /// Motions of the board onto itself after which the squares look as before: the identity first.
  [[nodiscard]] std::vector<SE3> pattern_turns() const;
  /// The same for the plate alone.
  [[nodiscard]] std::vector<SE3> plate_turns() const;

  /// Root mean square distance of the plate's corners under two poses.
  [[nodiscard]] double corner_distance(const SE3& a, const SE3& b) const;

 private:
  int columns_ = 0;
  int rows_ = 0;
  double square_ = 0.0;
  Eigen::Vector2d size_;
  Eigen::Vector2d offset_;
  int dictionary_ = -1;
  double marker_ = 0.0;
};

}  // namespace rigcal
