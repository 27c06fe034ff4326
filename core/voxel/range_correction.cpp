#include "core/voxel/range_correction.h"

#include <algorithm>

namespace rigcal {
namespace {

// Nearer points have no direction to speak of.
constexpr double nearest_m = 0.01;

// To first order in the cell's size over its range: what lies across the ray shrinks with the range.
void shorten(Cell& cell, double offset_m) {
  const double range = std::max(nearest_m, cell.mean.norm());
  const Vector3d d = cell.mean / range;
  const Matrix3d A = Matrix3d::Identity() - offset_m / range * (Matrix3d::Identity() - d * d.transpose());
  const Matrix3d S = A * cell.scatter_matrix() * A.transpose();
  cell.scatter << S(0, 0), S(0, 1), S(0, 2), S(1, 1), S(1, 2), S(2, 2);
  cell.mean -= offset_m * d;
}

}  // namespace

void shorten_ranges(PatchCells& patch, double offset_m) {
  for (Cell& cell : patch.cells) shorten(cell, offset_m);
  for (Cell& piece : patch.pieces) shorten(piece, offset_m);
  for (Point& p : patch.thinned) {
    const Vector3d at(p.x, p.y, p.z);
    const Vector3d moved = at - offset_m / std::max(nearest_m, at.norm()) * at;
    p.x = static_cast<float>(moved.x());
    p.y = static_cast<float>(moved.y());
    p.z = static_cast<float>(moved.z());
  }
}

}  // namespace rigcal
