#pragma once

#include <string>

#include "core/rig/rig.h"

namespace rigcal {

/// A rig with the text that it was read from: who needs both must not read twice, since a pipe gives it but once.
struct RigFile {
  std::string text;
  Rig rig;
};

/// Errors: those of `load_rig`.
[[nodiscard]] Expected<RigFile> load_rig_file(const std::string& path);

}  // namespace rigcal
