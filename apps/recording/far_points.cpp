#include "apps/recording/far_points.h"

#include "core/base/text.h"

namespace rigcal {

std::vector<std::string> far_point_warnings(const Rig& rig, const LidarRecording& recording) {
  std::vector<std::uint64_t> used(recording.lidar_sensors.size());
  for (const PatchCells& patch : recording.patches) used[static_cast<std::size_t>(patch.lidar)] += patch.points;
  std::vector<std::string> warnings;
  for (std::size_t i = 0; i < used.size(); ++i) {
    const std::uint64_t far = recording.too_far_of(i);
    if (far <= used[i]) continue;
    const std::string& name = rig.sensors[static_cast<std::size_t>(recording.lidar_sensors[i])].name;
    warnings.push_back(name + ": " + std::to_string(far) + " of its " + std::to_string(far + used[i]) +
                       " points in the stops lie farther than " + fixed_text(CellOptions{}.max_range_m, 0) +
                       " m, where none are used; let it see nearer surfaces");
  }
  return warnings;
}

}  // namespace rigcal
