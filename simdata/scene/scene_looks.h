#pragma once

#include <vector>

#include "core/rig/yaml_tree.h"
#include "simdata/scene/scene.h"

/// The parts of a scene file that say what surfaces look like and what light falls on them.
namespace rigcal::sim {

/// The map `materials`: a reflectivity for each name, or a map of it and more. Errors go to the map's own.
[[nodiscard]] std::vector<Material> read_materials(const YamlMap& scene);

/// The map `light`; daylight where there is none.
[[nodiscard]] Light read_light(const YamlMap& scene);

}  // namespace rigcal::sim
