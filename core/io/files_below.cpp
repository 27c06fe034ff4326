#include "core/io/files_below.h"

#include <algorithm>

#include "core/rig/text_file.h"

namespace rigcal {
namespace {

namespace fs = std::filesystem;

// Adds the names of what is in `folder`, and what is in the folders there. `above`: it and those that it is in.
Expected<void> add_files(const fs::path& folder, const fs::path& seen_from, std::vector<fs::path>& above,
                         std::vector<std::string>& names) {
  std::error_code error;
  const fs::path place = fs::canonical(folder, error);
  if (error) return cannot_read(folder.string(), error.value());
  if (std::find(above.begin(), above.end(), place) != above.end()) return {};
  above.push_back(place);
  fs::directory_iterator at(folder, error);
  for (; !error && at != fs::directory_iterator(); at.increment(error)) {
    std::error_code dangling;  // What a link leads to may be gone: then it is a name and no folder.
    if (!fs::is_directory(at->path(), dangling)) {
      names.push_back(at->path().lexically_relative(seen_from).string());
    } else if (const Expected<void> added = add_files(at->path(), seen_from, above, names); !added) {
      return added;
    }
  }
  above.pop_back();
  if (error) return cannot_read(folder.string(), error.value());
  return {};
}

}  // namespace

Expected<std::vector<std::string>> files_below(const fs::path& folder, const fs::path& left_out) {
  std::vector<fs::path> above;
  if (!left_out.empty()) {
    std::error_code error;
    above.push_back(fs::canonical(left_out, error));
    if (error) return cannot_read(left_out.string(), error.value());
  }
  std::vector<std::string> names;
  if (const Expected<void> added = add_files(folder, folder, above, names); !added) return added.error();
  std::sort(names.begin(), names.end());
  return names;
}

}  // namespace rigcal
