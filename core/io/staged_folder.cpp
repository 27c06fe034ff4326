#include "core/io/staged_folder.h"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <utility>

#include "core/io/output_file.h"

namespace rigcal {
namespace {

namespace fs = std::filesystem;

/// "a/b/" and "a/b" are one folder; the names beside it need the second form.
std::string without_slash(const std::string& path) {
  const fs::path tidy = fs::path(path).lexically_normal();
  return tidy.has_filename() ? tidy.string() : tidy.parent_path().string();
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

Expected<std::string> make_staging(const std::string& target) {
  const std::string staging = target + ".part" + std::to_string(::getpid());
  std::error_code error;
  if (fs::create_directory(staging, error)) return staging;
  return cannot_write(target, error ? error.value() : EEXIST);
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
  const std::string target = without_slash(path);
  if (exists(target)) return input_error("exists already", path, "choose another name");
  Expected<std::string> staging = make_staging(target);
  if (!staging) return staging.error();
  return StagedFolder(target, std::move(*staging), {});
}

Expected<StagedFolder> StagedFolder::replace(const std::string& path, std::vector<std::string> own_entries) {
  const std::string target = without_slash(path);
  if (exists(target)) {
    const Expected<void> replaceable = check_replaceable(target, own_entries);
    if (!replaceable) return replaceable.error();
  }
  Expected<std::string> staging = make_staging(target);
  if (!staging) return staging.error();
  return StagedFolder(target, std::move(*staging), std::move(own_entries));
}

Expected<void> StagedFolder::commit() {
  RIGCAL_ASSERT(!staging_.empty(), "the folder " + target_ + " was committed before");
  std::string old;
  if (exists(target_)) {
    // Somebody may have put files there in the meantime.
    const Expected<void> replaceable = check_replaceable(target_, own_entries_);
    if (!replaceable) return replaceable.error();
    old = target_ + ".old" + std::to_string(::getpid());
    if (std::rename(target_.c_str(), old.c_str()) != 0) return cannot_write(target_, errno);
  }
  if (std::rename(staging_.c_str(), target_.c_str()) != 0) {
    const Error error = cannot_write(target_, errno);
    if (!old.empty()) static_cast<void>(std::rename(old.c_str(), target_.c_str()));
    return error;
  }
  staging_.clear();
  std::error_code ignored;
  if (!old.empty()) fs::remove_all(old, ignored);
  return {};
}

}  // namespace rigcal
