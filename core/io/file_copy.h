#pragma once

#include <string>

#include "core/base/error.h"

namespace rigcal {

/// Copies a file; what is at `to` already is replaced. Errors: it is a folder, a pipe or a device, or cannot be read to
/// its end; it cannot be written, where a full disk is called that.
Expected<void> copy_file(const std::string& from, const std::string& to);

}  // namespace rigcal
