#include "apps/exchange/image_files.h"

#include <array>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <string>

#include "apps/recording/recorded_formats.h"
#include "apps/recording/ros_pixels.h"
#include "core/io/frame_files.h"
#include "core/io/output_file.h"

namespace rigcal {
namespace {

namespace fs = std::filesystem;

/// ".png" or ".jpg" by the first bytes; empty: neither.
std::string ending_of(ByteView data) {
  constexpr std::array<std::uint8_t, 4> png{0x89, 'P', 'N', 'G'};
  constexpr std::array<std::uint8_t, 3> jpeg{0xFF, 0xD8, 0xFF};
  if (data.size() >= png.size() && std::equal(png.begin(), png.end(), data.begin())) return ".png";
  if (data.size() >= jpeg.size() && std::equal(jpeg.begin(), jpeg.end(), data.begin())) return ".jpg";
  return "";
}

/// The pixel_format of an image that is a mosaic; of a compressed one the pixels have to confirm it.
std::string mosaic_of(const RecordedImage& image) {
  std::string named = bayer_format(image.image);
  if (named.empty() || image.type != RosType::compressed_image) return named;
  const Expected<Image> pixels = image_of(image.type, image.image);
  return pixels ? pixels->pixel_format : std::string();
}

}  // namespace

Expected<void> ImageFiles::restart() {
  std::error_code error;
  fs::remove_all(folder_, error);
  cameras_.clear();
  status_ = {};
  return error ? Expected<void>(cannot_write(folder_, error.value())) : Expected<void>{};
}

std::string ImageFiles::camera_folder(int sensor) const {
  return (fs::path(folder_) / rig_.sensors[static_cast<std::size_t>(sensor)].name).string();
}

void ImageFiles::write(const RecordedImage& image) {
  if (takes_ && status_) status_ = write_frame(image, cameras_[image.sensor]);
}

Expected<void> ImageFiles::write_frame(const RecordedImage& image, Camera& camera) const {
  const bool packed = image.type == RosType::compressed_image;
  const std::string ending = packed ? ending_of(image.image.data) : ".png";
  const std::optional<PixelView> pixels = packed ? std::nullopt : pixels_of(image.image);
  if (ending.empty() || (!packed && !pixels)) {
    if (++camera.unknown == 1) camera.first_unknown = image.image.encoding;
    return {};
  }
  const std::string folder = camera_folder(image.sensor);
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) return cannot_write(folder, error.value());
  char name[32];
  std::snprintf(name, sizeof name, "%06zu", camera.frames.size());
  FrameRecord frame;
  frame.file = name + ending;
  frame.stamp_ns = image.stamp_ns;
  if (image.image.header.stamp_ns > 0) frame.device_stamp = image.image.header.stamp_ns;
  const std::string path = (fs::path(folder) / frame.file).string();
  if (packed) {
    Expected<OutputFile> file = OutputFile::create(path);
    if (!file) return file.error();
    file->write(image.image.data);
    if (Expected<void> closed = file->close(); !closed) return closed;
  } else if (const Expected<void> written = write_png(path, *pixels); !written) {
    if (written.error().kind != ErrorKind::input) return written;
    if (++camera.unknown == 1) camera.first_unknown = image.image.encoding + " of a size that does not fit";
    return {};
  }
  if (camera.bayer.empty()) camera.bayer = mosaic_of(image);
  camera.frames.push_back(frame);
  return {};
}

Expected<void> ImageFiles::finish(const std::vector<Stop>& stops) {
  for (auto& [sensor, camera] : cameras_) {
    if (camera.frames.empty()) continue;
    const Sensor& told = rig_.sensors[static_cast<std::size_t>(sensor)];
    const auto half_ns = static_cast<std::int64_t>(500.0 * told.camera->exposure_us.value_or(0.0));
    for (FrameRecord& frame : camera.frames) {
      const std::optional<std::size_t> at =
          stop_that_contains(stops, frame.stamp_ns - half_ns, frame.stamp_ns + half_ns);
      if (at) frame.stop = stops[*at].index;
    }
    const std::string path = (fs::path(camera_folder(sensor)) / "frames.csv").string();
    if (Expected<void> written = write_frames(path, camera.frames); !written) return written;
  }
  return {};
}

std::uint64_t ImageFiles::images() const {
  std::uint64_t count = 0;
  for (const auto& [sensor, camera] : cameras_) count += camera.frames.size();
  return count;
}

std::map<int, std::string> ImageFiles::missing_formats() const {
  std::map<int, std::string> missing;
  for (const auto& [sensor, camera] : cameras_) {
    const std::string& told = rig_.sensors[static_cast<std::size_t>(sensor)].camera->pixel_format;
    if (is_misread(camera.bayer, told)) missing[sensor] = camera.bayer;
  }
  return missing;
}

std::vector<std::string> ImageFiles::warnings() const {
  std::vector<std::string> warnings;
  for (const auto& [sensor, camera] : cameras_) {
    if (camera.unknown == 0) continue;
    warnings.push_back(rig_.sensors[static_cast<std::size_t>(sensor)].name + ": " + std::to_string(camera.unknown) +
                       " images are of an encoding that is not known (" + camera.first_unknown + ") and were left out");
  }
  return warnings;
}

}  // namespace rigcal
