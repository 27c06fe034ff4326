#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/pipeline/lidar_calibration.h"
#include "simdata/rig/light_rig.h"

namespace rigcal::speed {

/// How large a simulated run is. Points are shots: some see the sky.
struct SetOptions {
  std::string scene = "courtyard";
  int lidars = 4;  ///< An AVIA, and MID-40 that look around it.
  int stops = 20;
  double points = 4e6;  ///< Of the whole run, about.
  std::uint64_t seed = 1;
};

/// A run in memory: what a calibration takes, and its points.
struct SpeedSet {
  Rig rig;
  RigState truth;
  std::vector<Patch> patches;
  std::vector<std::optional<SE3>> guess;
  LidarRecording recording;  ///< Without cells, see `take_cells`.
  std::uint64_t points = 0;

  /// As `calibrate` makes them, with points for the map where asked for.
  [[nodiscard]] std::vector<PatchCells> cells(bool with_map) const;
};

/// Errors: the scene.
[[nodiscard]] Expected<SpeedSet> make_set(const SetOptions& options);

}  // namespace rigcal::speed
