#pragma once

#include <string>

namespace rigcal {

/// The path of a rig file that comes with the program ("turntable", "loopback"); what is a path, or no such name, comes
/// back as it was given. Looked for beside the program, as it is installed and as it is built, and where it was to be
/// installed.
[[nodiscard]] std::string rig_file(const std::string& given);

}  // namespace rigcal
