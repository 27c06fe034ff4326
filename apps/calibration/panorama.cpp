#include "apps/calibration/panorama.h"

#include <algorithm>
#include <cmath>

namespace rigcal {

Panorama find_panorama(const LidarRecording& recording, const RigState& state, const std::vector<char>& stop_known,
                       const std::vector<char>& lidar_known) {
  constexpr double highest = pi / 4.0;
  Panorama out;
  out.seen_by.assign(static_cast<std::size_t>(Panorama::rows) * Panorama::columns, 0);
  for (const PatchCells& patch : recording.patches) {
    const auto stop = static_cast<std::size_t>(patch.stop);
    if (stop >= stop_known.size() || !stop_known[stop] || patch.lidar >= Panorama::most_lidars ||
        !lidar_known[static_cast<std::size_t>(patch.lidar)]) {
      continue;
    }
    const SE3 T = state.T_G_sensor(patch.stop, patch.lidar);
    for (const Cell& cell : patch.cells) {
      const Vector3d p = T * cell.mean;
      const double elevation = std::atan2(p.z(), std::hypot(p.x(), p.y()));
      const int row = static_cast<int>(std::floor((highest - elevation) / (2.0 * highest) * Panorama::rows));
      if (row < 0 || row >= Panorama::rows) continue;
      // Left is left, as in a picture taken from the middle.
      const double turn = (pi - std::atan2(p.y(), p.x())) / (2.0 * pi);
      const int column = std::min(Panorama::columns - 1, static_cast<int>(turn * Panorama::columns));
      out.seen_by[static_cast<std::size_t>(row * Panorama::columns + column)] |= 1U
                                                                                 << static_cast<unsigned>(patch.lidar);
    }
  }
  return out;
}

}  // namespace rigcal
