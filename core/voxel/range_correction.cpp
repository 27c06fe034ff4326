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

double darkness_in_the_mean(const std::vector<Cell>& pieces) {
  double sum = 0.0;
  double N = 0.0;
  for (const Cell& piece : pieces) {
    sum += piece.N * piece.darkness;
    N += piece.N;
  }
  return N > 0.0 ? sum / N : 0.0;
}

}  // namespace

void shorten_ranges(PatchCells& patch, const RangeError& error) {
  const double of_cubes_m = error.at(darkness_in_the_mean(patch.pieces));
  for (Cell& cell : patch.cells) shorten(cell, of_cubes_m);
  for (Cell& piece : patch.pieces) shorten(piece, error.at(piece.darkness));
  for (Point& p : patch.thinned) {
    const Vector3d at(p.x, p.y, p.z);
    const Vector3d moved = at - error.at(darkness_of(p.reflectivity)) / std::max(nearest_m, at.norm()) * at;
    p.x = static_cast<float>(moved.x());
    p.y = static_cast<float>(moved.y());
    p.z = static_cast<float>(moved.z());
  }
}

}  // namespace rigcal
