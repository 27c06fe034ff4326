#include "core/io/staged_folder.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <utility>

#include "core/base/file_descriptor.h"
#include "core/io/folder_contents.h"
#include "core/io/output_file.h"

namespace rigcal {
namespace {

namespace fs = std::filesystem;

/// The folder's own place and name: absolute, links followed (the folder behind a link is replaced, not the link), and
/// without a slash at the end, because other names are made beside it.
std::string own_place(const std::string& path) {
  std::error_code error;
  fs::path place = fs::weakly_canonical(fs::absolute(path, error), error);
  if (error) place = fs::path(path).lexically_normal();
  return place.has_filename() ? place.string() : place.parent_path().string();
}

bool exists(const std::string& path) {
  std::error_code error;
  return fs::exists(fs::symlink_status(path, error));
}

/// An error where the folder at `path` holds anything that is not ours.
Expected<void> check_replaceable(const std::string& path, const std::vector<std::string>& own_entries) {
  std::error_code error;
  if (!fs::is_directory(path, error)) return input_error("exists and is no folder", path, "choose another name");
  fs::directory_iterator entries(path, error);
  if (error) return cannot_write(path, error.value());
  for (const fs::directory_entry& entry : entries) {
    const std::string name = entry.path().filename().string();
    if (std::find(own_entries.begin(), own_entries.end(), name) != own_entries.end()) continue;
    return input_error("exists and holds '" + name + "', so it is not replaced", path, "choose another name");
  }
  return {};
}

/// A hidden folder of `target` in `place`, which must be there.
Expected<std::string> make_hidden(const std::string& target, const fs::path& place) {
  std::error_code error;
  const std::string stem = "." + fs::path(target).filename().string() + ".part" + std::to_string(::getpid()) + "-";
  // A name may be left from a killed process of the same number; it is never ours to remove.
  for (int i = 0; i < 100; ++i) {
    const fs::path staging = place / (stem + std::to_string(i));
    if (fs::create_directory(staging, error)) return staging.string();
    if (error) return cannot_write(target, error.value());
  }
  return cannot_write(target, EEXIST);
}

/// Beside the target, within one that is mounted: on the same file system, so that a rename is enough. The folders
/// above are made.
Expected<std::string> make_staging(const std::string& target) {
  if (is_mounted(target)) return make_hidden(target, target);
  const fs::path above = fs::path(target).parent_path();
  std::error_code error;
  fs::create_directories(above, error);
  if (error) return cannot_write(above.string(), error.value());
  return make_hidden(target, above);
}

/// Lets two folders change places: in one step where the file system can do that. After an error nothing has changed.
Expected<void> swap_places(const std::string& staging, const std::string& target) {
  if (::renameat2(AT_FDCWD, staging.c_str(), AT_FDCWD, target.c_str(), RENAME_EXCHANGE) == 0) return {};
  const std::string aside = staging + "-old";
  if (std::rename(target.c_str(), aside.c_str()) != 0) return cannot_write(target, errno);
  if (std::rename(staging.c_str(), target.c_str()) != 0) {
    const Error error = cannot_write(target, errno);
    static_cast<void>(std::rename(aside.c_str(), target.c_str()));
    return error;
  }
  static_cast<void>(std::rename(aside.c_str(), staging.c_str()));
  return {};
}

/// `call` is fsync, for the names in a folder, or syncfs. Some network file systems know neither of a folder.
Expected<void> sync_folder(const std::string& path, int (*call)(int)) {
  const FileDescriptor folder(::open(path.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (!folder.is_open()) return cannot_write(path, errno);
  const int code = call(folder.get()) == 0 ? 0 : errno;
  if (code != 0 && code != EINVAL && code != ENOSYS) return cannot_write(path, code);
  return {};
}

}  // namespace

StagedFolder::StagedFolder(std::string target, std::string staging, std::vector<std::string> own_entries)
    : target_(std::move(target)), staging_(std::move(staging)), own_entries_(std::move(own_entries)) {}

StagedFolder::StagedFolder(StagedFolder&& other) noexcept
    : target_(std::move(other.target_)),
      staging_(std::exchange(other.staging_, {})),
      own_entries_(std::move(other.own_entries_)) {}

StagedFolder::~StagedFolder() {
  if (staging_.empty()) return;
  std::error_code error;
  fs::remove_all(staging_, error);
}

Expected<StagedFolder> StagedFolder::create(const std::string& path) {
  const std::string target = own_place(path);
  if (exists(target)) return input_error("exists already", path, "choose another name");
  Expected<std::string> staging = make_staging(target);
  if (!staging) return staging.error();
  return StagedFolder(target, std::move(*staging), {});
}

Expected<StagedFolder> StagedFolder::replace(const std::string& path, std::vector<std::string> own_entries) {
  const std::string target = own_place(path);
  if (exists(target)) {
    const Expected<void> replaceable = check_replaceable(target, own_entries);
    if (!replaceable) return replaceable.error();
  }
  Expected<std::string> staging = make_staging(target);
  if (!staging) return staging.error();
  return StagedFolder(target, std::move(*staging), std::move(own_entries));
}

Expected<void> StagedFolder::check_place(const std::string& path) {
  const std::string target = own_place(path);
  fs::path above = fs::path(target).parent_path();
  while (above.has_relative_path() && !exists(above.string())) above = above.parent_path();
  const Expected<std::string> trial = make_hidden(target, is_mounted(target) ? fs::path(target) : above);
  if (!trial) return trial.error();
  std::error_code error;
  fs::remove(*trial, error);
  return error ? Expected<void>(cannot_write(*trial, error.value())) : Expected<void>{};
}

Expected<void> StagedFolder::sync() {
  return sync_folder(staging_, [](int descriptor) { return ::syncfs(descriptor); });
}

Expected<void> StagedFolder::commit() {
  RIGCAL_ASSERT(!staging_.empty(), "the folder " + target_ + " was committed before");
  if (Expected<void> synced = sync_folder(staging_, ::fsync); !synced) return synced;
  if (exists(target_)) {
    // Somebody may have put files there in the meantime.
    std::vector<std::string> ours = own_entries_;
    ours.push_back(fs::path(staging_).filename().string());
    if (Expected<void> replaceable = check_replaceable(target_, ours); !replaceable) return replaceable;
    if (must_stay(target_)) {
      const std::string first = own_entries_.empty() ? std::string() : own_entries_.front();
      if (Expected<void> done = replace_contents(target_, staging_, first); !done) return done;
      staging_.clear();
      return sync_folder(target_, ::fsync);
    }
    if (Expected<void> done = swap_places(staging_, target_); !done) return done;
    std::error_code ignored;
    fs::remove_all(staging_, ignored);  // the older folder by now
  } else if (std::rename(staging_.c_str(), target_.c_str()) != 0) {
    return cannot_write(target_, errno);
  }
  staging_.clear();
  return sync_folder(fs::path(target_).parent_path().string(), ::fsync);
}

}  // namespace rigcal
