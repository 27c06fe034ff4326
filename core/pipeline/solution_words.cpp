#include "core/pipeline/solution_words.h"

#include <algorithm>
#include <cstdio>

namespace rigcal {

std::string move_words(const std::vector<ExtrinsicMove>& moves) {
  double m = 0.0;
  double rad = 0.0;
  for (const ExtrinsicMove& move : moves) {
    m = std::max(m, move.translation_m);
    rad = std::max(rad, move.rotation_rad);
  }
  char text[120];
  std::snprintf(text, sizeof text, "a pass moved LiDARs by at most %.3f mm, %.5f deg", 1e3 * m, to_deg(rad));
  return text;
}

std::string place_words(int lidar, const LidarSolution& solution) {
  const auto i = static_cast<std::size_t>(lidar);
  const SE3& T = solution.state.T_base_sensor[i];
  const Vector3d phi = log_so3(T.R);
  const NoiseModel& noise = solution.noise[i];
  char text[240];
  std::snprintf(text, sizeof text,
                "LiDAR %d t [%.4f %.4f %.4f] m, rotation vector [%.4f %.4f %.4f] deg, match %.2f (next %.2f), noise "
                "%.1f mm + %.2f mm/m, %.3f deg, %.2f at a slant",
                lidar, T.t.x(), T.t.y(), T.t.z(), to_deg(phi.x()), to_deg(phi.y()), to_deg(phi.z()),
                solution.start.matches[i].score, solution.start.matches[i].runner_up_score, 1e3 * noise.range_m,
                1e3 * noise.range_per_m, to_deg(noise.angle_rad), noise.slant_growth);
  return text;
}

}  // namespace rigcal
