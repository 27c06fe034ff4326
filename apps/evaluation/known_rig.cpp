#include "apps/evaluation/known_rig.h"

#include <algorithm>
#include <filesystem>

#include "core/base/seconds.h"
#include "core/io/extrinsics_file.h"
#include "core/io/ground_truth.h"
#include "core/io/sensor_transforms.h"
#include "core/io/tum_file.h"
#include "core/rig/text_file.h"

namespace rigcal {
namespace {

namespace fs = std::filesystem;

// No session has so many stops, and no session clock (UTC) reads so little.
constexpr std::int64_t most_stops = 1'000'000;

Status status_from(const std::string& word) {
  for (const Status status : {Status::good, Status::weak, Status::failed}) {
    if (word == to_string(status)) return status;
  }
  return Status::good;
}

KnownRig from_file(const ExtrinsicsFile& file) {
  KnownRig rig;
  rig.base = file.base;
  for (const auto& [name, T_base_sensor] : file.T_base_sensor) {
    const auto status = file.status.find(name);
    const auto covariance = file.covariance.find(name);
    KnownRig::Entry entry{name, Status::good, T_base_sensor, std::nullopt};
    if (status != file.status.end()) entry.status = status_from(status->second);
    if (covariance != file.covariance.end()) entry.covariance = covariance->second;
    rig.sensors.push_back(entry);
  }
  for (const auto& [name, status] : file.status) {
    if (file.T_base_sensor.count(name) == 0) rig.sensors.push_back({name, status_from(status), {}, {}});
  }
  return rig;
}

// Whole small numbers are stops of an input without times; anything else is a time.
std::vector<KnownRig::Pose> poses_from(const std::vector<TumPose>& lines) {
  const bool numbered = std::all_of(lines.begin(), lines.end(), [](const TumPose& line) {
    return line.stamp_ns >= 0 && line.stamp_ns % ns_per_second == 0 && line.stamp_ns / ns_per_second < most_stops;
  });
  std::vector<KnownRig::Pose> poses;
  for (const TumPose& line : lines) {
    KnownRig::Pose pose{std::nullopt, line.stamp_ns, line.stamp_ns, line.pose};
    if (numbered) pose.stop = static_cast<int>(line.stamp_ns / ns_per_second);
    poses.push_back(pose);
  }
  return poses;
}

}  // namespace

Expected<KnownRig> load_result(const std::string& path) {
  const Expected<ExtrinsicsFile> extrinsics = load_extrinsics(path);
  if (!extrinsics) return extrinsics.error();
  KnownRig rig = from_file(*extrinsics);
  const fs::path trajectory = fs::path(path) / "trajectory.tum";
  std::error_code error;
  if (fs::is_directory(path, error) && fs::exists(trajectory, error)) {
    const Expected<std::vector<TumPose>> lines = read_tum(trajectory.string());
    if (!lines) return lines.error();
    rig.poses = poses_from(*lines);
  }
  return rig;
}

Expected<KnownRig> load_truth(const std::string& path) {
  const Expected<std::string> file = extrinsics_path(path);
  if (!file) return file.error();
  const Expected<std::string> text = read_text_file(*file, transforms_limits.max_bytes);
  if (!text) return text.error();
  const Expected<ExtrinsicsFile> extrinsics = parse_extrinsics(*text, *file);
  if (!extrinsics) return extrinsics.error();
  KnownRig rig = from_file(*extrinsics);
  if (!extrinsics->has_stops) return rig;
  const Expected<GroundTruth> truth = parse_ground_truth(*text, *file);
  if (!truth) return truth.error();
  for (const StopTruth& stop : truth->stops) {
    rig.poses.push_back({stop.stop.index, stop.stop.start_ns, stop.stop.end_ns, stop.T_G_base});
  }
  return rig;
}

}  // namespace rigcal
