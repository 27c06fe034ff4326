#include "core/board/board_model.h"

#include <cmath>

#include "core/rig/marker_dictionaries.h"

namespace rigcal {
namespace {

// Sides of a plate that differ by less than this share cannot be told apart.
constexpr double equal_sides = 0.02;

SE3 turn_about(const Eigen::Vector2d& center, int quarters) {
  const Vector3d c(center.x(), center.y(), 0.0);
  // Exact, so that a turn by a half is its own inverse.
  constexpr int cosines[] = {1, 0, -1, 0};
  const int co = cosines[quarters % 4];
  const int si = cosines[(quarters + 3) % 4];
  SE3 turn;
  turn.R << co, -si, 0, si, co, 0, 0, 0, 1;
  turn.t = c - turn.R * c;
  return turn;
}

}  // namespace

BoardModel::BoardModel(const BoardSettings& settings)
    : columns_(settings.inner_corners[0]),
      rows_(settings.inner_corners[1]),
      square_(settings.square),
      size_(settings.size[0], settings.size[1]),
      offset_(settings.offset[0], settings.offset[1]),
      dictionary_(settings.dictionary.empty() ? -1 : marker_dictionary(settings.dictionary)),
      marker_(settings.marker) {
  if (!(size_.x() > 0.0)) {
    size_ = square_ * Eigen::Vector2d(columns_ + 1, rows_ + 1);
    offset_.setZero();
  }
}

Vector3d BoardModel::lattice(double column, double row) const {
  return {offset_.x() + square_ * (column - 0.5 * (columns_ - 1)), offset_.y() + square_ * (row - 0.5 * (rows_ - 1)),
          0.0};
}

int BoardModel::id_at(const Vector3d& p) const {
  const double column = (p.x() - offset_.x()) / square_ + 0.5 * (columns_ - 1);
  const double row = (p.y() - offset_.y()) / square_ + 0.5 * (rows_ - 1);
  const double c = std::round(column);
  const double r = std::round(row);
  if (c < 0.0 || r < 0.0 || c >= columns_ || r >= rows_) return -1;
  if (std::abs(column - c) > 0.25 || std::abs(row - r) > 0.25) return -1;
  return static_cast<int>(r) * columns_ + static_cast<int>(c);
}

int BoardModel::colour_at(double x, double y, double margin) const {
  const double column = (x - offset_.x()) / square_ + 0.5 * (columns_ + 1);
  const double row = (y - offset_.y()) / square_ + 0.5 * (rows_ + 1);
  const double c = std::floor(column);
  const double r = std::floor(row);
  if (c < 0.0 || r < 0.0 || c > columns_ || r > rows_) return 0;
  const auto near_line = [&](double v) { return std::abs(v - std::round(v)) < margin; };
  if (near_line(column) || near_line(row)) return 0;
  return (static_cast<int>(c) + static_cast<int>(r)) % 2 == 0 ? 1 : -1;
}

std::array<Vector3d, 4> BoardModel::plate_corners() const {
  const double x = 0.5 * size_.x();
  const double y = 0.5 * size_.y();
  return {Vector3d(-x, -y, 0.0), Vector3d(x, -y, 0.0), Vector3d(x, y, 0.0), Vector3d(-x, y, 0.0)};
}

std::vector<SE3> BoardModel::pattern_turns() const {
  std::vector<SE3> turns{SE3{}};
  // The square at the far corner has the colour of the first one where columns and rows are both even or both odd.
  const bool by_half = (columns_ + rows_) % 2 == 0;
  const bool by_quarter = columns_ == rows_ && columns_ % 2 == 0;
  if (by_quarter) turns.push_back(turn_about(offset_, 1));
  if (by_half) turns.push_back(turn_about(offset_, 2));
  if (by_quarter) turns.push_back(turn_about(offset_, 3));
  return turns;
}

std::vector<SE3> BoardModel::plate_turns() const {
  const bool is_square = std::abs(size_.x() - size_.y()) < equal_sides * size_.maxCoeff();
  std::vector<SE3> turns;
  for (int quarters = 0; quarters < 4; quarters += is_square ? 1 : 2) {
    turns.push_back(turn_about(Eigen::Vector2d::Zero(), quarters));
  }
  return turns;
}

double BoardModel::corner_distance(const SE3& a, const SE3& b) const {
  double sum = 0.0;
  for (const Vector3d& corner : plate_corners()) sum += (a * corner - b * corner).squaredNorm();
  return std::sqrt(sum / 4.0);
}

}  // namespace rigcal
