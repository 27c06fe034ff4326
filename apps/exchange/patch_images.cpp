#include "apps/exchange/patch_images.h"

#include <filesystem>
#include <set>
#include <vector>

#include "apps/recording/bag_batches.h"
#include "apps/recording/bag_images.h"
#include "apps/recording/recorded_formats.h"
#include "apps/recording/recording.h"
#include "apps/recording/still_images.h"
#include "core/base/parallel.h"
#include "core/io/image_file.h"

namespace rigcal {
namespace {

// Of patches also stops without a cloud: a trajectory may have their poses, and calibrate then uses their images.
std::vector<Stop> stops_of(const StreamSource& source, const std::vector<StopRecord>& records,
                           const std::vector<std::string>& places) {
  std::vector<Stop> stops;
  std::set<int> known;
  for (const StopRecord& record : records) {
    stops.push_back(record.stop);
    known.insert(record.stop.index);
  }
  std::error_code error;
  if (!std::filesystem::is_directory(source.file, error)) return stops;
  for (const int stop : stops_with_images(source.rig, places)) {
    if (known.insert(stop).second) stops.push_back({stop, 0, 0});
  }
  return stops;
}

Expected<void> write_images(const StillImages& taken, int sensor, const std::vector<Stop>& stops,
                            const PatchFolderWriter& folder) {
  std::vector<std::string> paths;
  for (const StillImage& image : taken.images) {
    Expected<std::string> path = folder.image_path(sensor, stops[static_cast<std::size_t>(image.stop)].index);
    if (!path) return path.error();
    paths.push_back(std::move(*path));
  }
  std::vector<Expected<void>> written(paths.size());
  parallel_for(paths.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) written[k] = write_image(paths[k], taken.images[k].image);
  });
  for (const Expected<void>& one : written) {
    if (!one) return one;
  }
  return {};
}

}  // namespace

Expected<PatchImages> write_patch_images(const StreamSource& source, const std::vector<StopRecord>& stops,
                                         const PatchFolderWriter& folder, const RunContext& context) {
  const std::vector<std::string> places = image_places({source.path, {}, {}});
  const std::vector<Stop> all = stops_of(source, stops, places);
  PatchImages out;
  for (const CameraRecording& camera :
       is_bag(source.path)
           ? bag_camera_recordings(source.rig, all, source.path)
           : camera_recordings(source.rig, all, places,
                               "the recording has no images of it; give them to calibrate by --images DIR")) {
    const Sensor& sensor = source.rig.sensors[static_cast<std::size_t>(camera.sensor)];
    const StillImages taken = camera.read_images(context);
    if (context.cancelled()) return cancelled_error("stopped", source.path);
    if (taken.images.empty()) {
      context.reporter.warn(sensor.name + ": no image of it is written: " + taken.why_none);
      continue;
    }
    if (const Expected<void> written = write_images(taken, camera.sensor, all, folder); !written)
      return written.error();
    const std::string& format = taken.images.front().image.pixel_format;
    if (is_misread(format, sensor.camera->pixel_format)) out.missing_formats[camera.sensor] = format;
    out.files += taken.images.size();
  }
  return out;
}

}  // namespace rigcal
