#pragma once

#include <optional>
#include <string>

#include "core/base/error.h"
#include "core/io/input_file.h"

namespace rigcal {

/// So many first bytes tell what a file is.
constexpr std::size_t foreign_file_bytes = 16;

/// What is often given where a recording is asked for, by its first bytes, and what to do with it; nothing where they
/// are of no such file.
[[nodiscard]] std::optional<Error> foreign_file_error(ByteView begin, const std::string& path);
/// The same of a folder.
[[nodiscard]] std::optional<Error> foreign_folder_error(const std::string& path);

}  // namespace rigcal
