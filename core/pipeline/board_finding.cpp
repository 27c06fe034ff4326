#include "core/pipeline/board_finding.h"

#include <algorithm>

#include "core/base/parallel.h"
#include "core/base/text.h"
#include "core/edges/grey_image.h"

namespace rigcal {

SensorBoards find_lidar_boards(const Rig& rig, int sensor, const std::vector<Patch>& all, const BoardModel& board,
                               std::uint64_t seed, const RunContext& context) {
  const LidarSettings& settings = *rig.sensors[static_cast<std::size_t>(sensor)].lidar;
  std::vector<const Patch*> patches;
  for (const Patch& patch : all) {
    if (patch.sensor == sensor) patches.push_back(&patch);
  }
  std::vector<CloudBoards> found(patches.size());
  parallel_for(patches.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end && !context.cancelled(); ++k) {
      found[k] = find_cloud_boards(patches[k]->points, board, settings.rings, seed);
    }
  });
  SensorBoards out;
  out.views = static_cast<int>(patches.size());
  for (std::size_t k = 0; k < patches.size(); ++k) {
    const int stop = patches[k]->stop;
    if (found[k].boards.empty()) out.why_none[stop] = found[k].why_none;
    for (CloudBoard& b : found[k].boards) out.sightings.push_back(cloud_sighting(sensor, stop, std::move(b), board));
  }
  return out;
}

SensorBoards find_camera_boards(const Rig& rig, const CameraRecording& camera, const BoardModel& board,
                                bool guess_intrinsics, const RunContext& context) {
  const Sensor& sensor = rig.sensors[static_cast<std::size_t>(camera.sensor)];
  SensorBoards out;
  out.camera = sensor.camera->intrinsics;
  if (!out.camera && !guess_intrinsics) {
    out.why_not =
        "the rig file has no intrinsics for it; put them in, or have them found from these images by "
        "--refine-intrinsics";
    return out;
  }
  const StillImages still = camera.read_images(context);
  if (still.images.empty()) {
    out.why_not = still.why_none;
    return out;
  }
  std::vector<ImageBoards> found(still.images.size());
  parallel_for(found.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end && !context.cancelled(); ++k) {
      const Image& image = still.images[k].image;
      found[k] = find_image_boards(to_grey(image, value_bits(image)), board);
    }
  });
  out.views = static_cast<int>(found.size());
  if (!out.camera) {
    std::vector<ImageBoard> all;
    for (const ImageBoards& f : found) all.insert(all.end(), f.boards.begin(), f.boards.end());
    const Image& first = still.images[0].image;
    out.camera = rough_intrinsics(all, board, DistortionModel::radtan, first.width, first.height);
    if (!out.camera) {
      out.why_not =
          "its intrinsics cannot be found from these images; show it the whole board at least three times, "
          "leaning in different ways";
      return out;
    }
  }
  const CameraModel model(*out.camera);
  for (std::size_t k = 0; k < found.size(); ++k) {
    const int stop = still.images[k].stop;
    if (!found[k].why_none.empty()) (found[k].boards.empty() ? out.why_none : out.why_part)[stop] = found[k].why_none;
    for (ImageBoard& b : found[k].boards) {
      const std::optional<ImagePose> pose = find_image_pose(b, board, model);
      if (!pose) continue;
      out.sightings.push_back(image_sighting(camera.sensor, stop, std::move(b), *pose, board, model));
    }
    if (!found[k].boards.empty()) out.images.push_back({stop, still.images[k].file});
  }
  return out;
}

std::string commonest_reason(const std::map<int, std::string>& why_none, const std::vector<Stop>& stops) {
  std::map<std::string, std::vector<int>> by_reason;
  for (const auto& [stop, why] : why_none) by_reason[why].push_back(stop);
  const auto most = std::max_element(by_reason.begin(), by_reason.end(),
                                     [](const auto& a, const auto& b) { return a.second.size() < b.second.size(); });
  if (most == by_reason.end()) return "it saw nothing";
  return most->first + " (" + counted(most->second.size(), "stop") + ", the first is " +
         std::to_string(stops[static_cast<std::size_t>(most->second[0])].index) + ")";
}

}  // namespace rigcal
