#include "core/corner/cloud_overlap.h"

#include <utility>

namespace rigcal {
namespace {

constexpr std::size_t most_shapes = 1500;

std::vector<LocalShape> sharpened_shapes(const PatchCells& cells, const ShapeLevel& level) {
  std::vector<LocalShape> shapes = extract_shapes(cells, level.size_m);
  for (LocalShape& s : shapes) s.covariance = sharpened(s.covariance, level.sigma_m);
  return shapes;
}

}  // namespace

CloudOverlap::CloudOverlap(const PatchCells& a, const PatchCells& b, const ShapeLevel& level)
    : map_({}, level.reach_m) {
  std::vector<LocalShape> fixed = sharpened_shapes(a, level);
  std::vector<LocalShape> moving = sharpened_shapes(b, level);
  turned_ = fixed.size() < moving.size();
  if (turned_) std::swap(fixed, moving);
  map_ = ShapeIndex(fixed, level.reach_m);
  MovingShapes all{{SE3{}}, {}};
  for (const LocalShape& s : moving) all.items.push_back({0, s});
  moving_ = thinned(all, most_shapes);
}

double CloudOverlap::score(const SE3& T_a_b) const {
  return shape_score({map_, moving_}, turned_ ? T_a_b.inverse() : T_a_b);
}

}  // namespace rigcal
