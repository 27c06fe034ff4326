#pragma once

#include "core/io/extrinsics_file.h"
#include "core/rig/sensor_reader.h"

namespace rigcal {

/// A run of a thousand stops with all its poses stays far below these.
constexpr YamlLimits transforms_limits{std::size_t{8} << 20, 400'000, 16};

/// Reads `base` and `sensors` of an extrinsics.yaml or ground_truth.yaml; mistakes go to the map's errors.
[[nodiscard]] ExtrinsicsFile read_sensor_transforms(const YamlMap& top);

}  // namespace rigcal
