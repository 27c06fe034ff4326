#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "apps/experiment/targetless/camera_set.h"
#include "apps/experiment/targetless/lidar_experiments.h"

namespace rigcal::targetless {

/// Figs. 13 and 14: what became of all trials with one LiDAR by one method.
struct CameraRow {
  std::string pair;  ///< "LiDAR to camera" or "camera to camera" (both by the same LiDAR).
  std::string lidar;
  bool overlaps = false;
  std::string method;
  int trials = 0;  ///< Of both cameras,
  int found = 0;   ///< and those with an answer.
  MeanSpread rotation_rad;
  MeanSpread translation_m;
  double median_rotation_rad = 0.0;
  double median_translation_m = 0.0;
  double seconds = 0.0;  ///< Mean of a camera, its features apart.
};

/// Table II: what a method needs once for the map, and for one iteration with all images of a camera; 0: it has none.
struct CameraSeconds {
  std::string method;
  double planes_s = 0.0;  ///< From points on: cells or voxels, and their planes.
  double edges_s = 0.0;
  double match_s = 0.0;
  double solve_s = 0.0;
  std::size_t voxels = 0;       ///< That planes were looked for in.
  std::size_t edge_points = 0;  ///< Of the map.
};

struct CameraExperiment {
  int trials = 0;
  MeanSpread guess_rotation_rad;
  MeanSpread guess_translation_m;
  std::vector<CameraRow> rows;
};

/// Guesses with the means and the spreads that the paper has for "5 degrees and 0.1 m". Errors: cancelled.
[[nodiscard]] Expected<CameraExperiment> try_cameras(int trials, const CameraSetOptions& options,
                                                     const RunContext& context);

/// With the LiDAR that looks where the cameras look. Errors: cancelled.
[[nodiscard]] Expected<std::vector<CameraSeconds>> measure_cameras(const CameraSetOptions& options,
                                                                   const RunContext& context);

}  // namespace rigcal::targetless
