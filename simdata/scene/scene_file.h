#pragma once

#include <string>
#include <vector>

#include "core/base/error.h"
#include "simdata/scene/scene.h"

/// Scene files (YAML, `rigcal: 1`): materials, the turntable's place, the ground, objects by shape, walking people.
/// The files in config/scenes show every key.
namespace rigcal::sim {

/// Names of the scenes that come with the program (config/scenes, built in).
[[nodiscard]] std::vector<std::string> builtin_scenes();

/// A built-in scene by its name, or a scene file by its path (what has a slash or ends in .yaml). Errors name
/// "file:line" and the mend: unknown keys, shapes and materials, values of the wrong kind or out of range.
[[nodiscard]] Expected<Scene> load_scene(const std::string& name_or_path);

/// The same from text; `name` stands for the file in errors.
[[nodiscard]] Expected<Scene> parse_scene(const std::string& text, const std::string& name);

}  // namespace rigcal::sim
