#include "core/corner/plane_area.h"

#include <cmath>

namespace rigcal {
namespace {

constexpr double on_sigmas = 2.5;
constexpr double around_sigmas = 7.5;  // three times as far: of points that lie anywhere a third is on the plane
constexpr int least_points = 2;

}  // namespace

PlaneArea::PlaneArea(const FittedPlane& plane, const std::vector<Vector3d>& points, double part_m)
    : center_(plane.points.mean()), part_m_(part_m), number_(side_ * side_, -1) {
  const PlaneMoments moments = moments_of(plane.points);
  along_ = moments.axes.col(2);
  across_ = moments.axes.col(1);
  std::vector<int> on(number_.size(), 0);
  std::vector<int> around(number_.size(), 0);
  for (const Vector3d& p : points) {
    const double d = std::abs(plane.distance(p));
    if (d > around_sigmas * plane.sigma_m) continue;
    const std::int64_t slot = slot_of(p);
    if (slot < 0) continue;
    ++around[static_cast<std::size_t>(slot)];
    if (d <= on_sigmas * plane.sigma_m) ++on[static_cast<std::size_t>(slot)];
  }
  for (std::size_t slot = 0; slot < number_.size(); ++slot) {
    if (on[slot] >= least_points && 2 * on[slot] >= around[slot]) number_[slot] = parts_++;
  }
}

PlaneArea PlaneArea::common(const std::vector<PlaneArea>& areas) {
  PlaneArea out = areas.front();
  out.parts_ = 0;
  for (std::size_t slot = 0; slot < out.number_.size(); ++slot) {
    int seen = 0;
    for (const PlaneArea& area : areas) seen += area.number_[slot] >= 0 ? 1 : 0;
    out.number_[slot] = seen >= 2 ? out.parts_++ : -1;
  }
  return out;
}

std::int64_t PlaneArea::slot_of(const Vector3d& p) const {
  const Vector3d d = p - center_;
  const auto x = static_cast<std::int64_t>(std::floor(along_.dot(d) / part_m_)) + side_ / 2;
  const auto y = static_cast<std::int64_t>(std::floor(across_.dot(d) / part_m_)) + side_ / 2;
  return x < 0 || y < 0 || x >= side_ || y >= side_ ? -1 : x * side_ + y;
}

int PlaneArea::part_of(const Vector3d& p) const {
  const std::int64_t slot = slot_of(p);
  return slot < 0 ? -1 : number_[static_cast<std::size_t>(slot)];
}

}  // namespace rigcal
