#pragma once

#include <vector>

#include "core/voxel/cells.h"

namespace rigcal {

/// A flat piece of a patch, about half a metre wide, in the sensor's frame. Far from the truth surfaces are recognised
/// by these, not by raw voxels: a normal survives an error of position.
struct Surfel {
  Vector3d mean = Vector3d::Zero();
  Vector3d normal = Vector3d::UnitZ();  ///< Unit, towards the sensor.
  double N = 0.0;
  double variance = 0.0;  ///< Of its points along the normal, m^2, unbiased.
};

/// All surfels of one patch.
struct PatchSurfels {
  int lidar = 0;
  int stop = 0;
  std::vector<Surfel> surfels;
};

struct SurfelOptions {
  double size_m = 0.5;  ///< Finest; what has too few points for it is tried at two and four times the size.
  double min_points = 20.0;
  double max_thickness_m = 0.05;
};

[[nodiscard]] PatchSurfels extract_surfels(const PatchCells& patch, const SurfelOptions& options);
/// For all patches, in parallel, in their order.
[[nodiscard]] std::vector<PatchSurfels> extract_surfels(const std::vector<PatchCells>& patches,
                                                        const SurfelOptions& options);

/// Some of them, evenly over each patch: about `all` together, but `least` of each patch that has so many. A search
/// takes time with the square of their density.
[[nodiscard]] std::vector<PatchSurfels> thinned(const std::vector<PatchSurfels>& patches, std::size_t all,
                                                std::size_t least);

}  // namespace rigcal
