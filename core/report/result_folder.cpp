#include "core/report/result_folder.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "core/io/output_file.h"
#include "core/report/map_ply.h"
#include "core/report/result_texts.h"

namespace rigcal {
namespace {

namespace fs = std::filesystem;

// Everything that a version of rigcal ever wrote into a result folder.
constexpr std::array<const char*, 5> known_files{"extrinsics.yaml", "trajectory.tum", "report.json", "report.html",
                                                 "map.ply"};

Error refused(const std::string& what, const fs::path& path, const std::string& why) {
  return system_error(what + " (" + why + ")", path.string(), "choose another --out or mend its permissions");
}

Error not_ours(const std::string& what, const fs::path& path) {
  return input_error(what, path.string(), "choose another --out, or move it away yourself");
}

bool is_extrinsics_file(const fs::path& path) {
  std::ifstream in(path);
  std::string first;
  return std::getline(in, first) && first.rfind("rigcal:", 0) == 0;
}

// A new folder beside the target, on the same file system so that a rename is enough. It is removed with all that is in
// it at the end; when the result was put in place that is the older result, or nothing.
class TemporaryFolder {
 public:
  explicit TemporaryFolder(const fs::path& target) {
    const std::string stem = "." + target.filename().string() + ".rigcal-" + std::to_string(getpid()) + "-";
    bool made = false;
    // A name may be left from a killed process of the same number; it is never ours to remove.
    for (int i = 0; i < 100 && !made && !error_; ++i) {
      path_ = target.parent_path() / (stem + std::to_string(i));
      made = fs::create_directory(path_, error_);
    }
    if (!made && !error_) error_ = std::make_error_code(std::errc::file_exists);
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    if (!error_) fs::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  [[nodiscard]] const fs::path& path() const { return path_; }
  [[nodiscard]] const std::error_code& error() const { return error_; }

 private:
  fs::path path_;
  std::error_code error_;
};

Expected<void> write_text(const fs::path& path, const std::string& text) {
  Expected<OutputFile> file = OutputFile::create(path.string());
  if (!file) return file.error();
  file->write(text);
  if (Expected<void> synced = file->sync(); !synced) return synced;
  return file->close();
}

// Brings the names in a folder to the disk.
Expected<void> sync_folder(const fs::path& path) {
  const int descriptor = open(path.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return cannot_write(path.string(), errno);
  const int problem = fsync(descriptor) == 0 ? 0 : errno;
  close(descriptor);
  // Some network file systems know no fsync of a folder.
  if (problem != 0 && problem != EINVAL) return cannot_write(path.string(), problem);
  return {};
}

// Puts `complete` where `target` is. An older result changes places with it in one step, where the file system can do
// that, and else is moved aside for a moment; `complete` then names the older one.
Expected<void> swap_in(const fs::path& complete, const fs::path& target) {
  if (!fs::exists(target)) {
    if (std::rename(complete.c_str(), target.c_str()) != 0) return cannot_write(target.string(), errno);
    return {};
  }
  if (renameat2(AT_FDCWD, complete.c_str(), AT_FDCWD, target.c_str(), RENAME_EXCHANGE) == 0) return {};
  const fs::path aside = complete.string() + "-old";
  if (std::rename(target.c_str(), aside.c_str()) != 0) return cannot_write(target.string(), errno);
  if (std::rename(complete.c_str(), target.c_str()) != 0) {
    const Error error = cannot_write(target.string(), errno);
    std::rename(aside.c_str(), target.c_str());
    return error;
  }
  if (std::rename(aside.c_str(), complete.c_str()) != 0) return cannot_write(aside.string(), errno);
  return {};
}

// Absolute, links followed, no slash at the end: the folder's own place and name.
Expected<fs::path> resolve(const std::string& path) {
  std::error_code error;
  fs::path resolved = fs::weakly_canonical(fs::absolute(path, error), error);
  if (error) return refused("cannot use the folder", path, error.message());
  if (!resolved.has_filename()) resolved = resolved.parent_path();
  return resolved;
}

}  // namespace

Expected<void> check_result_target(const std::string& path) {
  const Expected<fs::path> resolved = resolve(path);
  if (!resolved) return resolved.error();
  std::error_code error;
  const fs::file_status status = fs::status(*resolved, error);
  if (status.type() == fs::file_type::not_found) return {};
  if (error) return refused("cannot look at the folder", *resolved, error.message());
  if (!fs::is_directory(status)) return not_ours("a file stands where the result folder should go", *resolved);
  bool empty = true;
  fs::directory_iterator entries(*resolved, error);
  if (error) return refused("cannot list the folder", *resolved, error.message());
  for (const fs::directory_entry& entry : entries) {
    empty = false;
    const std::string name = entry.path().filename();
    if (std::find(known_files.begin(), known_files.end(), name) == known_files.end() || !entry.is_regular_file(error)) {
      return not_ours("the folder holds \"" + name + "\", which is no part of a result, and is not replaced",
                      *resolved);
    }
  }
  if (!empty && !is_extrinsics_file(*resolved / "extrinsics.yaml")) {
    return not_ours("the folder has no extrinsics.yaml of rigcal and is not replaced", *resolved);
  }
  return {};
}

Expected<void> write_result_folder(const CalibrationResult& result, const std::string& path) {
  if (Expected<void> sound = check_result(result); !sound) return sound;
  if (Expected<void> free = check_result_target(path); !free) return free;
  const Expected<fs::path> target = resolve(path);
  if (!target) return target.error();
  std::error_code error;
  fs::create_directories(target->parent_path(), error);
  if (error) return refused("cannot make the folder", target->parent_path(), error.message());

  const TemporaryFolder temporary(*target);
  if (temporary.error()) return refused("cannot make a folder", temporary.path(), temporary.error().message());
  const fs::path& folder = temporary.path();
  if (Expected<void> done = write_text(folder / "extrinsics.yaml", extrinsics_yaml(result)); !done) return done;
  if (Expected<void> done = write_text(folder / "trajectory.tum", trajectory_tum(result)); !done) return done;
  if (Expected<void> done = write_text(folder / "report.json", report_json(result)); !done) return done;
  if (Expected<void> done = write_map_ply(result, (folder / "map.ply").string()); !done) return done;
  if (Expected<void> done = sync_folder(folder); !done) return done;
  if (Expected<void> done = swap_in(folder, *target); !done) return done;
  return sync_folder(target->parent_path());
}

}  // namespace rigcal
