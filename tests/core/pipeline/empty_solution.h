#pragma once

#include "core/pipeline/lidar_result.h"

namespace rigcal {

/// A solution in which nothing is known yet, for tests that fill in what they look at.
inline LidarSolution empty_solution(int stops, int lidars) {
  return {{}, {}, ParameterLayout(stops, lidars), {}, {}, {}, {}, {}, 0.0, {}, {}, {}, {}, {}};
}

}  // namespace rigcal
