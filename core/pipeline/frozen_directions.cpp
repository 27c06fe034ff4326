#include "core/pipeline/frozen_directions.h"

#include <algorithm>

#include "core/quality/lidar_quality.h"

namespace rigcal {

void freeze_open_directions(LidarSolution& s) {
  s.frozen.clear();
  const auto& matches = s.adjust.lidar_matches;
  if (std::none_of(matches.begin(), matches.end(), [](const auto& match) { return match.has_value(); })) return;
  const LidarCovariances covariances = lidar_covariances({s.refined.map.features, s.state, s.layout, s.adjust});
  s.frozen = covariances.only_matched;
  for (std::size_t i = 0; i < s.frozen.size(); ++i) {
    if (s.frozen[i].isZero() || !matches[i]) continue;
    SE3& T = s.state.T_base_sensor[i];
    const Vector3d axis = T.R * s.frozen[i];
    T.t += axis * axis.dot(matches[i]->T.t - T.t);
  }
}

}  // namespace rigcal
