#include "core/report/result_folder.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>

#include "core/io/output_file.h"
#include "core/io/staged_folder.h"
#include "core/report/map_ply.h"
#include "core/report/result_texts.h"

namespace rigcal {
namespace {

namespace fs = std::filesystem;

// Everything that a version of rigcal ever wrote into a result folder.
constexpr std::array<const char*, 5> known_files{"extrinsics.yaml", "trajectory.tum", "report.json", "report.html",
                                                 "map.ply"};

Error not_ours(const std::string& what, const std::string& path) {
  return input_error(what, path, "choose another --out, or move it away yourself");
}

bool is_extrinsics_file(const fs::path& path) {
  std::ifstream in(path);
  std::string first;
  return std::getline(in, first) && first.rfind("rigcal:", 0) == 0;
}

Expected<void> write_text(const fs::path& path, const std::string& text) {
  Expected<OutputFile> file = OutputFile::create(path.string());
  if (!file) return file.error();
  file->write(text);
  if (Expected<void> synced = file->sync(); !synced) return synced;
  return file->close();
}

}  // namespace

Expected<void> check_result_target(const std::string& path) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (status.type() == fs::file_type::not_found) return {};
  if (error) return cannot_write(path, error.value());
  if (!fs::is_directory(status)) return not_ours("a file stands where the result folder should go", path);
  fs::directory_iterator entries(path, error);
  if (error) return cannot_write(path, error.value());
  bool empty = true;
  for (const fs::directory_entry& entry : entries) {
    empty = false;
    const std::string name = entry.path().filename();
    if (std::find(known_files.begin(), known_files.end(), name) == known_files.end() || !entry.is_regular_file(error)) {
      return not_ours("the folder holds \"" + name + "\", which is no part of a result, and is not replaced", path);
    }
  }
  if (!empty && !is_extrinsics_file(fs::path(path) / "extrinsics.yaml")) {
    return not_ours("the folder has no extrinsics.yaml of rigcal and is not replaced", path);
  }
  return {};
}

Expected<void> write_result_folder(const CalibrationResult& result, const std::string& path) {
  if (Expected<void> sound = check_result(result); !sound) return sound;
  if (Expected<void> free = check_result_target(path); !free) return free;
  Expected<StagedFolder> staged = StagedFolder::replace(path, {known_files.begin(), known_files.end()});
  if (!staged) return staged.error();
  const fs::path folder = staged->path();
  if (Expected<void> done = write_text(folder / "extrinsics.yaml", extrinsics_yaml(result)); !done) return done;
  if (Expected<void> done = write_text(folder / "trajectory.tum", trajectory_tum(result)); !done) return done;
  if (Expected<void> done = write_text(folder / "report.json", report_json(result)); !done) return done;
  if (Expected<void> done = write_map_ply(result, (folder / "map.ply").string()); !done) return done;
  return staged->commit();
}

}  // namespace rigcal
