#include <algorithm>
#include <cmath>

#include "core/board/board_adjustment.h"
#include "core/board/board_costs.h"

namespace rigcal {
namespace {

struct Mean {
  double squares = 0.0;
  double count = 0.0;
  void add(double value, double weight = 1.0) {
    squares += weight * value * value;
    count += weight;
  }
  [[nodiscard]] double root() const { return count > 0.0 ? std::sqrt(squares / count) : 0.0; }
};

}  // namespace

SightingResiduals residuals_of(const BoardSighting& sighting, const BoardSensor& sensor, const SE3& T_base_board,
                               const BoardModel& board) {
  SightingResiduals out;
  Mean all;
  const SE3 T_sensor_board = sensor.T_base_sensor.inverse() * T_base_board;
  if (sighting.image && sensor.camera) {
    const CameraModel camera(*sensor.camera);
    Mean pixels;
    for (std::size_t k = 0; k < sighting.image->ids.size(); ++k) {
      const auto pixel = camera.project(T_sensor_board * board.corner(sighting.image->ids[k]));
      const double off = pixel ? (*pixel - sighting.image->pixels[k]).norm() : 1e3;
      pixels.add(off);
      all.add(off / sensor.sigma_px, 0.5);
    }
    all.count = 2.0 * pixels.count;
    all.squares *= 2.0;
    out.pixels = pixels.root();
  }
  if (sighting.cloud) {
    const SE3 to_board = T_sensor_board.inverse();
    Mean plane;
    Mean border;
    for (const Vector3d& p : sighting.cloud->points) {
      plane.add((to_board * (p + sensor.range_offset_m * p.normalized())).z());
    }
    for (const BorderPoint& b : sighting.cloud->border) {
      const Vector3d q = to_board * (b.p + sensor.range_offset_m * b.p.normalized());
      const double growth = sensor.growth_m[b.axis] + sensor.widening * (b.p.norm() - sensor.usual_range_m);
      const double off = b.sign * q[b.axis] - 0.5 * board.size()[b.axis] - growth;
      // One that lies far out was a hand or a stand; the adjustment's robust loss bears with it as well.
      border.add(std::clamp(off, -3.0 * sensor.sigma_border_m, 3.0 * sensor.sigma_border_m));
    }
    out.plane_m = plane.root();
    out.border_m = border.root();
    all.add(out.plane_m / sensor.sigma_plane_m, plane.count);
    all.add(out.border_m / sensor.sigma_border_m, border.count);
  }
  out.normalised = all.root();
  return out;
}

}  // namespace rigcal
