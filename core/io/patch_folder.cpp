#include "core/io/patch_folder.h"

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <set>
#include <utility>

#include "core/base/parse_number.h"
#include "core/base/seconds.h"
#include "core/base/text.h"
#include "core/io/foreign_file.h"
#include "core/io/output_file.h"
#include "core/io/pcd_file.h"
#include "core/io/tum_file.h"
#include "core/rig/text_file.h"

namespace rigcal {
namespace {

namespace fs = std::filesystem;

constexpr int max_stop = 9'999'999;

std::string folder_of(const Sensor& sensor) { return sensor.folder.empty() ? sensor.name : sensor.folder; }

Expected<std::vector<std::string>> sorted_entries(const std::string& path) {
  std::error_code error;
  fs::directory_iterator entries(path, error);
  if (error) return cannot_read(path, error.value());
  std::vector<std::string> names;
  for (const fs::directory_entry& entry : entries) names.push_back(entry.path().filename().string());
  std::sort(names.begin(), names.end());
  return names;
}

/// The ending of a name, in small letters.
std::string ending_of(const std::string& name) { return small_letters(fs::path(name).extension().string()); }

/// The stop number of "<digits>.pcd", or -1.
int stop_number(const std::string& name) {
  constexpr std::string_view ending = ".pcd";
  if (name.size() <= ending.size() || name.size() > 16 || ending_of(name) != ending) return -1;
  if (name[0] < '0' || name[0] > '9') return -1;
  const auto stop = parse_number<int>(std::string_view(name).substr(0, name.size() - ending.size()));
  return stop && *stop <= max_stop ? *stop : -1;
}

Expected<std::vector<PatchFile>> list_sensor(const std::string& folder, std::vector<std::string>& unknown) {
  const Expected<std::vector<std::string>> names = sorted_entries(folder);
  if (!names) return names.error();
  std::vector<PatchFile> files;
  for (const std::string& name : *names) {
    const int stop = stop_number(name);
    const std::string path = (fs::path(folder) / name).string();
    if (stop < 0) {
      unknown.push_back((fs::path(folder).filename() / name).string());
    } else {
      files.push_back({stop, path});
    }
  }
  std::sort(files.begin(), files.end(), [](const PatchFile& a, const PatchFile& b) { return a.stop < b.stop; });
  for (std::size_t i = 1; i < files.size(); ++i) {
    if (files[i].stop != files[i - 1].stop) continue;
    return input_error("and " + files[i - 1].path + " are two clouds for stop " + std::to_string(files[i].stop),
                       files[i].path, "keep one of them");
  }
  return files;
}

Expected<std::map<int, SE3>> read_trajectory(const std::string& path) {
  const Expected<std::vector<TumPose>> poses = read_tum(path);
  if (!poses) return poses.error();
  std::map<int, SE3> by_stop;
  for (const TumPose& pose : *poses) {
    const std::string where = path + ":" + std::to_string(pose.line);
    if (pose.stamp_ns % ns_per_second != 0 || pose.stamp_ns < 0 || pose.stamp_ns / ns_per_second > max_stop) {
      return input_error("the first column is no stop number", where,
                         "in a patch folder it is the number of the stop, not a time");
    }
    const int stop = static_cast<int>(pose.stamp_ns / ns_per_second);
    if (!by_stop.emplace(stop, pose.pose).second) {
      return input_error("has stop " + std::to_string(stop) + " a second time", where, "keep one of them");
    }
  }
  return by_stop;
}

/// Why a file in a sensor's folder is no cloud that is read.
std::string reason_of_file(const std::string& name) {
  if (ending_of(name) == ".ply") return "PLY is not read: convert it to PCD";
  const std::string stem = fs::path(name).stem().string();
  if (ending_of(name) == ".pcd" && stem.find_first_not_of("0123456789.") == std::string::npos)
    return "a cloud is named by the number of its stop, like 3.pcd, not by a time: count them in their order";
  return "a cloud is named by the number of its stop, like 3.pcd";
}

constexpr std::size_t most_named = 10;

/// Of folders of sensors in which no file is read.
Error no_clouds(const std::string& path, const std::vector<std::string>& unknown) {
  if (unknown.empty()) {
    return input_error("its folders hold no clouds", path, "name them by their stop: 0.pcd, 1.pcd and so on");
  }
  const bool is_one = unknown.size() == 1;
  return input_error("its folders hold no clouds that are read, but " + std::to_string(unknown.size()) +
                         (is_one ? " other file: " : " other files, the first: ") + unknown.front(),
                     path, reason_of_file(unknown.front()));
}

Error no_sensor_folder(const std::string& path, const Rig& rig, const std::vector<std::string>& names) {
  if (auto foreign = foreign_folder_error(path)) return *std::move(foreign);
  const std::string what = "has no folder for any LiDAR of the rig; there are " + joined_some(names, most_named);
  std::string mend = "rename them, or set 'folder' in the rig file; wanted are";
  bool first = true;
  for (const Sensor& sensor : rig.sensors) {
    if (!sensor.is_lidar()) continue;
    mend.append(first ? " " : ", ").append(folder_of(sensor));
    first = false;
  }
  return input_error(what, path, mend);
}

}  // namespace

Expected<PatchFolder> list_patch_folder(const std::string& path, const Rig& rig, const std::string& trajectory_path) {
  const Expected<std::vector<std::string>> names = sorted_entries(path);
  if (!names) return names.error();
  if (names->empty()) return input_error("is empty", path, "give a folder with one folder of .pcd files a sensor");
  PatchFolder folder;
  folder.path = path;
  folder.patches.resize(rig.sensors.size());
  std::set<std::string> known{"image", "trajectory.tum", "rig.yaml"};
  std::set<int> stops;
  bool any_folder = false;
  bool any_lidar = false;
  for (std::size_t i = 0; i < rig.sensors.size(); ++i) {
    const std::string name = folder_of(rig.sensors[i]);
    known.insert(name);
    std::error_code error;
    const std::string sensor_path = (fs::path(path) / name).string();
    any_lidar |= rig.sensors[i].is_lidar();
    if (!rig.sensors[i].is_lidar() || !fs::is_directory(sensor_path, error)) continue;
    any_folder = true;
    Expected<std::vector<PatchFile>> files = list_sensor(sensor_path, folder.unknown);
    if (!files) return files.error();
    for (const PatchFile& file : *files) stops.insert(file.stop);
    folder.patches[i] = std::move(*files);
  }
  if (!any_lidar && !std::binary_search(names->begin(), names->end(), "image")) {
    return input_error("holds no images, and the rig has cameras alone", path,
                       "put them into image/<camera>/<stop>.png");
  }
  if (any_lidar && !any_folder) return no_sensor_folder(path, rig, *names);
  if (any_lidar && stops.empty()) {
    std::sort(folder.unknown.begin(), folder.unknown.end());
    return no_clouds(path, folder.unknown);
  }
  for (const std::string& name : *names) {
    if (!known.contains(name)) folder.unknown.push_back(name);
  }
  std::sort(folder.unknown.begin(), folder.unknown.end());
  folder.stops.assign(stops.begin(), stops.end());
  std::error_code error;
  const std::string own = (fs::path(path) / "trajectory.tum").string();
  const std::string tum = !trajectory_path.empty() ? trajectory_path : (fs::exists(own, error) ? own : std::string());
  if (!tum.empty()) {
    Expected<std::map<int, SE3>> trajectory = read_trajectory(tum);
    if (!trajectory) return trajectory.error();
    folder.trajectory = std::move(*trajectory);
  }
  return folder;
}

std::vector<std::string> reasons_of_unknown(const PatchFolder& folder) {
  std::vector<std::string> strangers;
  std::map<std::string, std::vector<std::string>> misnamed;
  for (const std::string& name : folder.unknown) {
    (fs::path(name).has_parent_path() ? misnamed[reason_of_file(name)] : strangers).push_back(name);
  }
  std::vector<std::string> reasons;
  if (!strangers.empty())
    reasons.push_back("not used, since no sensor of the rig has that name or folder: " +
                      joined_some(strangers, most_named));
  for (const auto& [reason, names] : misnamed)
    reasons.push_back("not used, since " + reason + ": " + joined_some(names, most_named));
  return reasons;
}

Expected<PatchFolderWriter> PatchFolderWriter::create(const std::string& path, const Rig& rig) {
  Expected<StagedFolder> folder = StagedFolder::create(path);
  if (!folder) return folder.error();
  std::vector<std::string> names;
  names.reserve(rig.sensors.size());
  for (const Sensor& sensor : rig.sensors) names.push_back(folder_of(sensor));
  return PatchFolderWriter(std::move(*folder), std::move(names));
}

Expected<PcdWriter> PatchFolderWriter::open(int sensor, int stop, PcdColumns columns) const {
  const fs::path folder = fs::path(folder_.path()) / names_.at(static_cast<std::size_t>(sensor));
  std::error_code error;
  fs::create_directory(folder, error);
  if (error) return cannot_write(folder.string(), error.value());
  return PcdWriter::create((folder / (std::to_string(stop) + ".pcd")).string(), columns);
}

Expected<void> PatchFolderWriter::write(const Patch& patch) {
  Expected<PcdWriter> writer = open(patch.sensor, patch.stop);
  if (!writer) return writer.error();
  writer->write(patch.points);
  return writer->finish();
}

Expected<std::string> PatchFolderWriter::image_path(int sensor, int stop) const {
  const fs::path folder = fs::path(folder_.path()) / "image" / names_.at(static_cast<std::size_t>(sensor));
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) return cannot_write(folder.string(), error.value());
  return (folder / (std::to_string(stop) + ".png")).string();
}

Expected<void> PatchFolderWriter::write_rig_file(const std::string& text) const {
  return replace_file((fs::path(folder_.path()) / "rig.yaml").string(), text);
}

Expected<void> PatchFolderWriter::finish() {
  if (Expected<void> synced = folder_.sync(); !synced) return synced;
  return folder_.commit();
}

Expected<void> PatchFolderWriter::write_trajectory(const std::map<int, SE3>& poses) {
  std::vector<TumPose> lines;
  lines.reserve(poses.size());
  for (const auto& [stop, pose] : poses) lines.push_back({stop * ns_per_second, pose, 0});
  return write_tum((fs::path(folder_.path()) / "trajectory.tum").string(), lines, "stop tx ty tz qx qy qz qw");
}

}  // namespace rigcal
