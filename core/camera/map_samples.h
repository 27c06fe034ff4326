#pragma once

#include <cstddef>
#include <vector>

#include "core/camera/camera_scene.h"
#include "core/voxel/plane_feature.h"

namespace rigcal {

/// The map as samples, one for each cube of `size_m`: the mean of the thinned points of all patches with `use` (empty:
/// all) in it, with the normal of the leaf that it lies on, and the LiDAR that has most of these points with the median
/// of its reflectivities. `leaves` are features of the plane map (merged ones are left out). Those of a block of
/// `sample_block_cubes` each way come one after the other, within it in the order in which points met their cubes; it
/// depends on the patches only, not on the number of threads. Of more than `most_points` points every second, third ..
/// of each patch takes part: where there are so many, each cube has several.
[[nodiscard]] std::vector<MapSample> sample_map(const std::vector<PatchCells>& patches, const RigState& state,
                                                const std::vector<char>& use, const std::vector<PlaneFeature>& leaves,
                                                double size_m = 0.05, std::size_t most_points = 6'000'000);

}  // namespace rigcal
