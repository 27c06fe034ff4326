#pragma once

#include <string_view>
#include <vector>

namespace rigcal::sim {

struct BuiltinScene {
  std::string_view name;
  std::string_view text;
};

/// The files of config/scenes, put into the program when it is built.
[[nodiscard]] const std::vector<BuiltinScene>& builtin_scene_texts();

}  // namespace rigcal::sim
