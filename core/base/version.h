#pragma once

namespace rigcal {

/// The version of this software, "major.minor.patch" as in the top CMakeLists.txt.
[[nodiscard]] const char* version();

/// The version of the file formats that this software writes: the number behind `rigcal:` in every YAML file.
constexpr int format_version = 1;

}  // namespace rigcal
