#pragma once

#include <cstddef>
#include <string>

#include "core/base/error.h"

namespace rigcal {

/// The whole of a text file. Errors (all of kind input): missing, no permission, a folder, longer than `max_bytes`.
[[nodiscard]] Expected<std::string> read_text_file(const std::string& path, std::size_t max_bytes);

/// The error for an input file that could not be opened or read, from `errno`-like `code`.
[[nodiscard]] Error cannot_read(const std::string& path, int code);

/// Of an input that may be a file or a folder. Errors: nothing is there, or it may not be looked at.
[[nodiscard]] Expected<void> check_there(const std::string& path);

}  // namespace rigcal
