#pragma once

#include <optional>
#include <string>

#include "core/rig/rig.h"
#include "core/rig/yaml_tree.h"

namespace rigcal {

/// Reads one entry of a rig file's `sensors`; mistakes go to `errors`.
[[nodiscard]] Sensor read_sensor(const std::string& name, const YamlNode& node, YamlErrors& errors);

/// Reads `translation` (metres) and `rotation_xyzw` (a unit quaternion) of a map; nothing, and an error added, where
/// one is missing or wrong. The map may hold other keys.
[[nodiscard]] std::optional<SE3> read_transform(const YamlMap& map);

/// Reads `intrinsics` of a map that may hold other keys; nothing where it has none, or (after adding an error) a wrong
/// one.
[[nodiscard]] std::optional<CameraIntrinsics> read_intrinsics(const YamlMap& camera);

}  // namespace rigcal
