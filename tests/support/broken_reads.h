#pragma once

#include <fcntl.h>
#include <unistd.h>

#include <filesystem>
#include <string>
#include <vector>

namespace rigcal {

/// From now on every read of a file that this process has open fails, as on a disk that breaks (with EISDIR: a folder
/// is put under its descriptors). Whether it was open.
inline bool break_reads(const std::filesystem::path& path) {
  std::error_code error;
  const std::filesystem::path wanted = std::filesystem::canonical(path, error);
  std::vector<int> found;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd")) {
    if (std::filesystem::read_symlink(entry.path(), error) == wanted && !error)
      found.push_back(std::stoi(entry.path().filename().string()));
  }
  const int folder = ::open("/", O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  for (const int descriptor : found) ::dup3(folder, descriptor, O_CLOEXEC);
  ::close(folder);
  return !found.empty();
}

}  // namespace rigcal
