#pragma once

#include <filesystem>
#include <string>

namespace rigcal {

/// An empty folder of the test that runs, or of the suite that is set up, and of no other. It is removed when that has
/// ended, also where it failed (not where it crashed); with RIGCAL_KEEP_SCRATCH in the environment it stays, to be
/// looked at.
[[nodiscard]] std::filesystem::path scratch_folder(const std::string& name);

/// A file or folder of the test that runs; nothing stands there.
[[nodiscard]] std::string fresh_path(const std::string& name);

}  // namespace rigcal
