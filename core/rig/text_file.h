#pragma once

#include <cstddef>
#include <string>

#include "core/base/error.h"

namespace rigcal {

/// The whole of a text file. Errors: those of `cannot_read`, longer than `max_bytes`.
[[nodiscard]] Expected<std::string> read_text_file(const std::string& path, std::size_t max_bytes);

/// The error for an input file that could not be opened or read, from `errno`-like `code`: of kind input where the file
/// itself is why, of kind system (`read_failure`) where the disk or the network is.
[[nodiscard]] Error cannot_read(const std::string& path, int code);

/// A disk or a network file system did not give what the file holds: another try may. Never the file's end, so that a
/// part of a recording does not pass for all of it.
[[nodiscard]] Error read_failure(const std::string& path, const std::string& why);

/// Of an input that may be a file or a folder. Errors: nothing is there, or it may not be looked at.
[[nodiscard]] Expected<void> check_there(const std::string& path);

}  // namespace rigcal
