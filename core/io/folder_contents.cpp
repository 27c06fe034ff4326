#include "core/io/folder_contents.h"

#include <fcntl.h>
#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <utility>
#include <vector>

#include "core/io/output_file.h"

namespace rigcal {
namespace {

namespace fs = std::filesystem;

/// Whether `path` is the folder or something below it.
bool is_within(const fs::path& path, const fs::path& folder) {
  return std::mismatch(folder.begin(), folder.end(), path.begin(), path.end()).first == folder.end();
}

/// Files and folders below `folder`, as paths from it, each folder before what is in it; none that is hidden.
struct Entries {
  std::vector<fs::path> files;
  std::vector<fs::path> folders;
};

Expected<Entries> entries_of(const fs::path& folder) {
  Entries entries;
  std::error_code error;
  fs::recursive_directory_iterator it(folder, error);
  for (const fs::recursive_directory_iterator end; !error && it != end; it.increment(error)) {
    std::error_code gone;
    const bool is_folder = it->symlink_status(gone).type() == fs::file_type::directory;
    if (it.depth() == 0 && it->path().filename().string().front() == '.') {
      if (is_folder) it.disable_recursion_pending();
      continue;
    }
    (is_folder ? entries.folders : entries.files).push_back(it->path().lexically_relative(folder));
  }
  if (error) return cannot_write(folder.string(), error.value());
  std::sort(entries.files.begin(), entries.files.end());
  std::sort(entries.folders.begin(), entries.folders.end());
  return entries;
}

/// Renames that can be taken back.
class Moves {
 public:
  Moves() = default;
  Moves(const Moves&) = delete;
  Moves& operator=(const Moves&) = delete;
  ~Moves() {
    if (kept_) return;
    for (auto move = done_.rbegin(); move != done_.rend(); ++move)
      static_cast<void>(std::rename(move->second.c_str(), move->first.c_str()));
    for (auto folder = made_.rbegin(); folder != made_.rend(); ++folder) remove_empty(*folder);
  }

  Expected<void> make_folder(const fs::path& folder) {
    std::error_code error;
    if (fs::create_directory(folder, error)) made_.push_back(folder);
    if (error) return cannot_write(folder.string(), error.value());
    return {};
  }

  Expected<void> move(const std::vector<fs::path>& names, const fs::path& from, const fs::path& to) {
    for (const fs::path& name : names) {
      if (std::rename((from / name).c_str(), (to / name).c_str()) != 0)
        return cannot_write((to / name).string(), errno);
      done_.emplace_back(from / name, to / name);
    }
    return {};
  }

  void keep() { kept_ = true; }

  static void remove_empty(const fs::path& folder) {
    std::error_code ignored;
    fs::remove(folder, ignored);
  }

 private:
  std::vector<std::pair<fs::path, fs::path>> done_;
  std::vector<fs::path> made_;
  bool kept_ = false;
};

}  // namespace

bool is_mounted(const std::string& folder) {
  struct statx status {};
  return ::statx(AT_FDCWD, folder.c_str(), AT_NO_AUTOMOUNT, 0, &status) == 0 &&
         (status.stx_attributes & STATX_ATTR_MOUNT_ROOT) != 0;
}

bool must_stay(const std::string& folder) {
  if (is_mounted(folder)) return true;
  std::error_code error;
  fs::directory_iterator it("/proc", error);
  for (const fs::directory_iterator end; !error && it != end; it.increment(error)) {
    const std::string name = it->path().filename();
    if (name.find_first_not_of("0123456789") != std::string::npos) continue;
    std::error_code unseen;  // Of another user, or just over.
    const fs::path stands_in = fs::read_symlink(it->path() / "cwd", unseen);
    if (!unseen && is_within(stands_in, folder)) return true;
  }
  return false;
}

Expected<void> replace_contents(const std::string& folder, const std::string& fresh, const std::string& first) {
  Expected<Entries> old = entries_of(folder);
  if (!old) return old.error();
  Expected<Entries> coming = entries_of(fresh);
  if (!coming) return coming.error();
  const auto is_first = [&](const fs::path& name) { return name == first; };
  std::stable_partition(old->files.begin(), old->files.end(), is_first);
  std::stable_partition(coming->files.begin(), coming->files.end(), [&](const fs::path& n) { return !is_first(n); });

  const std::string aside = fresh + "-old";
  {
    Moves moves;
    if (Expected<void> done = moves.make_folder(aside); !done) return done;
    for (const fs::path& name : old->folders) {
      if (Expected<void> done = moves.make_folder(aside / name); !done) return done;
    }
    if (Expected<void> done = moves.move(old->files, folder, aside); !done) return done;
    for (const fs::path& name : coming->folders) {
      if (Expected<void> done = moves.make_folder(folder / name); !done) return done;
    }
    if (Expected<void> done = moves.move(coming->files, fresh, folder); !done) return done;
    moves.keep();
  }
  for (auto name = old->folders.rbegin(); name != old->folders.rend(); ++name) {
    // An empty one that still belongs stays with what it has now.
    if (std::find(coming->folders.begin(), coming->folders.end(), *name) == coming->folders.end())
      Moves::remove_empty(folder / *name);
  }
  std::error_code ignored;
  fs::remove_all(aside, ignored);
  fs::remove_all(fresh, ignored);
  return {};
}

}  // namespace rigcal
