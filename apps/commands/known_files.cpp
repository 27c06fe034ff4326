#include "apps/commands/known_files.h"

#include <filesystem>
#include <optional>
#include <vector>

#include "core/rig/rig.h"

namespace rigcal {
namespace {

namespace fs = std::filesystem;

/// `installed`: below the folder of the program's data; `source`: below the root of the source tree.
std::optional<std::string> find_shipped(const fs::path& installed, const fs::path& source) {
  std::error_code error;
  std::vector<fs::path> places{fs::path(RIGCAL_DATA_FOLDER) / installed, "/usr/share/rigcal" / installed};
  const fs::path program = fs::read_symlink("/proc/self/exe", error).parent_path();  // none where /proc is not mounted
  if (!error) places.insert(places.begin(), {program / "../share/rigcal" / installed, program / "../.." / source});
  for (const fs::path& place : places) {
    const fs::path file = place.lexically_normal();
    if (fs::exists(file, error)) return file.string();
  }
  return std::nullopt;
}

}  // namespace

std::string rig_file(const std::string& given) {
  std::error_code error;
  if (!is_plain_name(given) || fs::path(given).has_extension() || fs::exists(given, error)) return given;
  const fs::path file = fs::path("rigs") / (given + ".yaml");
  return find_shipped(file, "config" / file).value_or(given);
}

std::string shipped_file(const std::string& path) { return find_shipped(path, path).value_or(path); }

}  // namespace rigcal
