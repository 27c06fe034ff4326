#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/base/error.h"

namespace rigcal {

/// The names of all files in a folder and in those below it, behind symbolic links too, seen from it and in order. A
/// folder that a link leads back into is gone through once; `left_out`, a folder that may be below, not at all. Errors:
/// a part of it could not be looked at.
[[nodiscard]] Expected<std::vector<std::string>> files_below(const std::filesystem::path& folder,
                                                             const std::filesystem::path& left_out = {});

}  // namespace rigcal
