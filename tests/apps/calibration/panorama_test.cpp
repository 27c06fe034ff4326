// Which LiDARs have seen what, for the page of a capture.
#include "apps/calibration/panorama.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace rigcal {
namespace {

TEST(Panorama, HasEveryLidarThatIsRecordedLive) {
  constexpr int lidars = Panorama::most_lidars + 1;
  LidarRecording recording;
  for (int lidar = 0; lidar < lidars; ++lidar) {
    PatchCells& patch = recording.patches.emplace_back();
    patch.lidar = lidar;
    patch.cells.resize(1);
    patch.cells[0].mean = Vector3d(5.0, 0.0, 0.1);
  }
  const RigState state{{SE3{}}, std::vector<SE3>(lidars)};
  std::vector<char> known(lidars, 1);
  known[3] = 0;
  const Panorama seen = find_panorama(recording, state, {1}, known);
  EXPECT_EQ(*std::max_element(seen.seen_by.begin(), seen.seen_by.end()), 0xFFFF'FFF7U);
  EXPECT_EQ(std::count(seen.seen_by.begin(), seen.seen_by.end(), 0U), Panorama::rows * Panorama::columns - 1);
}

}  // namespace
}  // namespace rigcal
