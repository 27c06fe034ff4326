#pragma once

#include <cstdlib>
#include <filesystem>
#include <string>

namespace rigcal {

/// Where real recordings lie: $RIGCAL_TEST_DATA, else `shared/data` beside the checkout. Tests that need them skip,
/// saying so, where the folder is absent.
inline std::filesystem::path real_recordings() {
  const char* from_environment = std::getenv("RIGCAL_TEST_DATA");
  if (from_environment != nullptr && *from_environment != '\0') return from_environment;
  return std::filesystem::path(RIGCAL_SOURCE_DIR) / ".." / "shared" / "data";
}

}  // namespace rigcal
