#include "apps/known_files.h"

#include <filesystem>
#include <vector>

#include "core/rig/rig.h"

namespace rigcal {

std::string rig_file(const std::string& given) {
  namespace fs = std::filesystem;
  std::error_code error;
  if (!is_plain_name(given) || fs::path(given).has_extension() || fs::exists(given, error)) return given;
  std::vector<fs::path> folders{fs::path(RIGCAL_DATA_FOLDER) / "rigs", "/usr/share/rigcal/rigs"};
  const fs::path program = fs::read_symlink("/proc/self/exe", error).parent_path();  // none where /proc is not mounted
  if (!error) folders.insert(folders.begin(), {program / "../share/rigcal/rigs", program / "../../config/rigs"});
  for (const fs::path& folder : folders) {
    const fs::path file = (folder / (given + ".yaml")).lexically_normal();
    if (fs::exists(file, error)) return file.string();
  }
  return given;
}

}  // namespace rigcal
