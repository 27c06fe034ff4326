#include "apps/exchange/session_images.h"

#include <filesystem>
#include <optional>

#include "apps/recording/recording.h"
#include "apps/recording/still_images.h"
#include "core/io/file_copy.h"
#include "core/io/frame_files.h"
#include "core/io/image_folder.h"

namespace rigcal {
namespace {

namespace fs = std::filesystem;

std::string nothing_written(const Sensor& camera, const std::string& why) {
  return camera.name + ": no image of it is written: " + why;
}

void tell_of_unused_images(const Sensor& camera, const std::string& folder, const ImageFolder& listed,
                           Reporter& reporter) {
  const std::string mend = tell_of_unused(folder, listed, reporter);
  if (listed.images.empty()) reporter.warn(nothing_written(camera, "its folder " + folder + " holds no images" + mend));
}

FrameRecord frame_of(const ListedImage& image, std::optional<int> stop) {
  return {fs::path(image.path).filename().string(),
          image.number,
          image.trigger,
          image.exposure_us,
          image.device_stamp,
          stop};
}

/// Returns those that were copied.
Expected<std::vector<FrameRecord>> copy_files(const ImageFolder& listed, const std::vector<std::optional<int>>& stops,
                                              const fs::path& to, const RunContext& context) {
  std::vector<FrameRecord> frames;
  for (std::size_t k = 0; k < listed.images.size(); ++k) {
    if (context.cancelled()) return cancelled_error("stopped", listed.images[k].path);
    context.reporter.progress("copying images", static_cast<double>(k) / static_cast<double>(listed.images.size()));
    FrameRecord frame = frame_of(listed.images[k], stops.empty() ? listed.images[k].stop : stops[k]);
    if (const Expected<void> copied = copy_file(listed.images[k].path, (to / frame.file).string()); !copied) {
      if (copied.error().kind != ErrorKind::input) return copied.error();
      context.reporter.warn(copied.error().message());  // calibrate would leave it out, too
      continue;
    }
    frames.push_back(std::move(frame));
  }
  return frames;
}

}  // namespace

Expected<std::uint64_t> copy_images(const std::string& from, ImageNumbers numbers, const std::vector<Stop>& stops,
                                    const Rig& rig, const std::string& session, const RunContext& context) {
  std::uint64_t count = 0;
  for (const Sensor& camera : rig.sensors) {
    const std::string folder = camera.is_lidar() ? std::string() : image_folder_of(camera, {from});
    if (folder.empty()) continue;
    const Expected<ImageFolder> listed = list_image_folder(folder);
    if (!listed) return listed.error();
    tell_of_unused_images(camera, folder, *listed, context.reporter);
    const fs::path to = fs::path(session) / "images" / camera.name;
    std::error_code error;
    fs::create_directories(to, error);
    if (error) return cannot_write(to.string(), error.value());
    std::vector<std::optional<int>> remarks;
    if (!stops.empty()) remarks = stops_of_images(*listed, camera, stops);
    const Expected<std::vector<FrameRecord>> frames = copy_files(*listed, remarks, to, context);
    if (!frames) return frames.error();
    count += frames->size();
    if (!listed->has_frames && numbers == ImageNumbers::stops) continue;
    if (const Expected<void> written = write_frames((to / "frames.csv").string(), *frames); !written)
      return written.error();
  }
  return count;
}

std::uint64_t count_images(const std::string& from, const Rig& rig, Reporter& reporter) {
  std::uint64_t count = 0;
  for (const Sensor& camera : rig.sensors) {
    const std::string folder = camera.is_lidar() ? std::string() : image_folder_of(camera, {from});
    if (folder.empty()) continue;
    const Expected<ImageFolder> listed = list_image_folder(folder);
    if (!listed) {
      reporter.warn(listed.error().message());  // calibrate would do without them, too
      continue;
    }
    tell_of_unused_images(camera, folder, *listed, reporter);
    count += listed->images.size();
  }
  return count;
}

void warn_of_missing_images(const Rig& rig, const std::string& session, const std::string& given, Reporter& reporter) {
  const std::vector<std::string> places = image_places({session, {}, {}});
  for (const Sensor& camera : rig.sensors) {
    if (!camera.is_lidar() && image_folder_of(camera, places).empty())
      reporter.warn(nothing_written(camera, given.empty()
                                                ? "the recording has none that can be used; give them by --images DIR"
                                                : given + " has no folder of it with images"));
  }
}

}  // namespace rigcal
