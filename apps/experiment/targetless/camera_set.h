#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/pipeline/camera_stage.h"
#include "core/pipeline/lidar_result.h"

namespace rigcal::targetless {

struct CameraSetOptions {
  std::string scene = "courtyard";
  std::uint64_t seed = 1;
  int points = 100000;  ///< Of a patch.
  int stops = 20;
  int images = 10;           ///< Of a camera, at stops evenly over the turn.
  double image_scale = 1.0;  ///< Of 1280 x 1024 pixels.
};

/// One LiDAR, what it made of a turn by itself alone, and cameras to be found against that.
struct CameraSide {
  std::string lidar;
  bool overlaps = false;  ///< The cameras look where it looks; else away from it.
  std::vector<PatchCells> patches;
  double cells_s = 0.0;  ///< What it took to make them of the points.
  std::unique_ptr<LidarSolution> solution;
  CameraScene scene;
  std::vector<CameraTask> cameras;  ///< Without a guess; the edges of their images are known.
  std::vector<SE3> T_lidar_camera;  ///< Truth.
};

/// An AVIA that looks forward like two cameras of 1280 x 1024 pixels, and a MID-40 that looks back, on one turntable:
/// first with the AVIA, then with the MID-40 as the LiDAR. Errors: cancelled.
[[nodiscard]] Expected<std::vector<CameraSide>> make_camera_sides(const CameraSetOptions& options,
                                                                  const RunContext& context);

}  // namespace rigcal::targetless
