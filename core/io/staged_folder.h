#pragma once

#include <string>
#include <vector>

#include "core/base/error.h"

namespace rigcal {

/// A folder that appears as a whole or not at all: it is filled under a hidden name beside its place and renamed by
/// `commit`. Left uncommitted, it is removed again. Folders above it are made; a link to a folder is followed.
class StagedFolder {
 public:
  /// For a new folder; an existing path is an error (kind input).
  [[nodiscard]] static Expected<StagedFolder> create(const std::string& path);
  /// For a folder that may replace an older one: one that is empty or holds nothing but entries of these names. Any
  /// other existing path is an error, so that a slip of the user never costs his files. The first name is that of the
  /// entry that readers look for.
  [[nodiscard]] static Expected<StagedFolder> replace(const std::string& path, std::vector<std::string> own_entries);

  /// Whether a folder could be made at `path`, tried where its folders above end; nothing is left of it. Errors (kind
  /// system): no permission, no room, a file in the way.
  [[nodiscard]] static Expected<void> check_place(const std::string& path);

  StagedFolder(StagedFolder&& other) noexcept;
  StagedFolder& operator=(StagedFolder&&) = delete;
  StagedFolder(const StagedFolder&) = delete;
  StagedFolder& operator=(const StagedFolder&) = delete;
  ~StagedFolder();

  /// Where to write.
  [[nodiscard]] const std::string& path() const { return staging_; }
  /// Brings all that is in it to the disk, in one go: for folders of many files, which their writers do not sync one by
  /// one. Other files on that disk are waited for, too.
  Expected<void> sync();
  /// Renames it to its place, in one step also where an older folder is there, which is removed after that. A folder
  /// that is mounted, or that a program stands in, stays, and its files are replaced, the first name's last. Files that
  /// must outlive a power cut are synced before, by whoever writes them or by `sync`. After an Error nothing has
  /// changed.
  Expected<void> commit();

 private:
  StagedFolder(std::string target, std::string staging, std::vector<std::string> own_entries);

  std::string target_;
  std::string staging_;
  std::vector<std::string> own_entries_;
};

}  // namespace rigcal
