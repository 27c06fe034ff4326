#pragma once

#include <string>

namespace rigcal {

/// The path of a rig file that comes with the program ("turntable", "loopback"); what is a path, or no such name, comes
/// back as it was given. Looked for beside the program, as it is installed and as it is built, and where it was to be
/// installed.
[[nodiscard]] std::string rig_file(const std::string& given);

/// The path of a file that comes with the program, by its path in the source tree ("udev/install"), looked for in the
/// same places; as it was given where it is not found.
[[nodiscard]] std::string shipped_file(const std::string& path);

}  // namespace rigcal
