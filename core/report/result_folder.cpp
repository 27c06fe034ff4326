#include "core/report/result_folder.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <functional>
#include <string_view>
#include <vector>

#include "core/base/parallel.h"
#include "core/io/output_file.h"
#include "core/io/staged_folder.h"
#include "core/report/html/page.h"
#include "core/report/map_ply.h"
#include "core/report/result_texts.h"

namespace rigcal {
namespace {

namespace fs = std::filesystem;

// Everything that a version of rigcal ever wrote into a result folder.
constexpr std::array<const char*, 5> known_files{"extrinsics.yaml", "trajectory.tum", "report.json", "report.html",
                                                 "map.ply"};
constexpr const char* overlay_folder = "overlays";

Error not_ours(const std::string& what, const std::string& path) {
  return input_error(what, path, "choose another place for the result, or move it away yourself");
}

bool is_extrinsics_file(const fs::path& path) {
  std::ifstream in(path);
  std::string first;
  return std::getline(in, first) && first.rfind("rigcal:", 0) == 0;
}

std::string overlay_file(const CalibrationResult& result, const Overlay& overlay) {
  const int stop = result.trajectory[static_cast<std::size_t>(overlay.stop)].stop.index;
  return overlay.sensor + "_" + std::to_string(stop) + (overlay.kind == OverlayKind::map ? "_map.jpg" : ".jpg");
}

Expected<void> write_text(const fs::path& path, std::string_view text) {
  Expected<OutputFile> file = OutputFile::create(path.string());
  if (!file) return file.error();
  file->write(text);
  if (Expected<void> synced = file->sync(); !synced) return synced;
  return file->close();
}

// Files of a folder, or of the folder of pictures in it.
Expected<void> check_entries(const fs::path& folder, const std::string& path, bool pictures, bool& empty) {
  std::error_code error;
  fs::directory_iterator entries(folder, error);
  if (error) return cannot_write(folder.string(), error.value());
  for (const fs::directory_entry& entry : entries) {
    empty = false;
    const std::string name = entry.path().filename();
    if (!pictures && name == overlay_folder && entry.symlink_status(error).type() == fs::file_type::directory) {
      if (Expected<void> ours = check_entries(entry.path(), path, true, empty); !ours) return ours;
      continue;
    }
    const bool known = pictures ? entry.path().extension() == ".jpg"
                                : std::find(known_files.begin(), known_files.end(), name) != known_files.end();
    if (!known || !entry.is_regular_file(error)) {
      return not_ours("the folder holds \"" + (pictures ? overlay_folder + std::string("/") + name : name) +
                          "\", which is no part of a result, and is not replaced",
                      path);
    }
  }
  return {};
}

Expected<void> write_overlays(const CalibrationResult& result, const fs::path& folder) {
  if (result.overlays.empty()) return {};
  std::error_code error;
  if (!fs::create_directory(folder, error)) return cannot_write(folder.string(), error.value());
  for (const Overlay& overlay : result.overlays) {
    const std::string_view bytes(reinterpret_cast<const char*>(overlay.jpeg.data()), overlay.jpeg.size());
    if (Expected<void> done = write_text(folder / overlay_file(result, overlay), bytes); !done) return done;
  }
  return {};
}

}  // namespace

Expected<void> check_result_target(const std::string& path) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (status.type() == fs::file_type::not_found) return StagedFolder::check_place(path);
  if (error) return cannot_write(path, error.value());
  if (!fs::is_directory(status)) return not_ours("a file stands where the result folder should go", path);
  bool empty = true;
  if (Expected<void> ours = check_entries(path, path, false, empty); !ours) return ours;
  if (!empty && !is_extrinsics_file(fs::path(path) / "extrinsics.yaml")) {
    return not_ours("the folder has no extrinsics.yaml of rigcal and is not replaced", path);
  }
  return StagedFolder::check_place(path);
}

Expected<void> write_result_folder(const CalibrationResult& result, const std::string& path, const Rig* rig) {
  if (Expected<void> sound = check_result(result); !sound) return sound;
  if (Expected<void> free = check_result_target(path); !free) return free;
  std::vector<std::string> own_entries{known_files.begin(), known_files.end()};
  own_entries.emplace_back(overlay_folder);
  Expected<StagedFolder> staged = StagedFolder::replace(path, own_entries);
  if (!staged) return staged.error();
  const fs::path folder = staged->path();
  // The page and the map take longest, the map to reach the disk: side by side.
  const std::array<std::function<Expected<void>()>, 3> parts{
      [&] { return write_map_ply(result, (folder / "map.ply").string()); },
      [&] { return write_text(folder / "report.html", report_html(result, rig)); },
      [&]() -> Expected<void> {
        if (Expected<void> done = write_text(folder / "extrinsics.yaml", extrinsics_yaml(result)); !done) return done;
        if (Expected<void> done = write_text(folder / "trajectory.tum", trajectory_tum(result)); !done) return done;
        if (Expected<void> done = write_text(folder / "report.json", report_json(result)); !done) return done;
        return write_overlays(result, folder / overlay_folder);
      }};
  std::array<Expected<void>, parts.size()> written;
  parallel_for(parts.size(), 1, [&](std::size_t begin, std::size_t) { written[begin] = parts[begin](); });
  for (const Expected<void>& done : written) {
    if (!done) return done;
  }
  return staged->commit();
}

}  // namespace rigcal
