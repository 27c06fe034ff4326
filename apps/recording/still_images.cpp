#include "apps/recording/still_images.h"

#include <algorithm>
#include <filesystem>
#include <limits>
#include <map>

#include "apps/recording/stamp_guess.h"
#include "core/base/parallel.h"
#include "core/camera/working_size.h"
#include "core/io/image_file.h"

namespace rigcal {
namespace {

namespace fs = std::filesystem;

bool has_times(const std::vector<Stop>& stops) {
  return std::any_of(stops.begin(), stops.end(), [](const Stop& s) { return s.start_ns != 0 || s.end_ns != 0; });
}

std::optional<std::size_t> stop_of_index(const std::vector<Stop>& stops, std::int64_t index) {
  for (std::size_t j = 0; j < stops.size(); ++j) {
    if (stops[j].index == index) return j;
  }
  return std::nullopt;
}

struct Placed {
  std::size_t stop = 0;
  const ListedImage* image = nullptr;
};

/// Which images belong to which stop.
class Placing {
 public:
  Placing(const Sensor& camera, const ImageFolder& folder, const std::vector<Stop>& stops)
      : camera_(camera), folder_(folder), stops_(stops), timed_(has_times(stops)) {
    for (const ListedImage& image : folder.images) place(image);
  }

  [[nodiscard]] const std::vector<Placed>& placed() const { return placed_; }

  /// Why images are not used, for all of the camera; empty: all are.
  [[nodiscard]] std::string outside() const {
    if (outside_ == 0) return {};
    return camera_.name + ": " + std::to_string(outside_) + " of " + std::to_string(folder_.images.size()) +
           " images were taken outside of all stops and are not used, the first: " + first_outside_ + guess();
  }
  void tell(Reporter& reporter) const {
    if (outside_ > 0 && !placed_.empty()) reporter.warn(outside());
    if (contradicting_ > 0) {
      reporter.warn(camera_.name + ": frames.csv names another stop than the stamp for " +
                    std::to_string(contradicting_) + " images; the stamps count; the first: " + first_contradicting_);
    }
  }

 private:
  /// What may be wrong with the stamps where none is right, or with the numbers.
  [[nodiscard]] std::string guess() const {
    if (!timed_) return guess_of_numbers();
    if (!placed_.empty()) return {};
    std::vector<std::int64_t> stamps;
    for (const ListedImage& image : folder_.images) stamps.push_back(image.number);
    const std::string text = guess_of_stamps(stamps, stops_);
    return text.empty() ? text : "; " + text;
  }
  /// Images that are counted from another number than the stops are taken for those of other stops, all but one that
  /// has none. Empty: counted as the stops are, some would have none, too.
  [[nodiscard]] std::string guess_of_numbers() const {
    const auto first = [](const std::vector<std::int64_t>& all) { return *std::min_element(all.begin(), all.end()); };
    std::vector<std::int64_t> of_images;
    for (const ListedImage& image : folder_.images) {
      if (folder_.has_frames && !image.stop) return {};
      of_images.push_back(folder_.has_frames ? *image.stop : image.number);
    }
    std::vector<std::int64_t> of_stops;
    for (const Stop& stop : stops_) of_stops.push_back(stop.index);
    if (of_images.empty() || of_stops.empty()) return {};
    const std::int64_t off = first(of_images) - first(of_stops);
    const bool all_fit = std::all_of(of_images.begin(), of_images.end(), [&](std::int64_t number) {
      return stop_of_index(stops_, number - off).has_value();
    });
    if (off == 0 || !all_fit) return {};
    return "; images are numbered from " + std::to_string(first(of_images)) + ", stops from " +
           std::to_string(first(of_stops)) +
           ": if the first image belongs to the first stop, number them as the stops are, or each is taken for that of "
           "another stop";
  }
  void place(const ListedImage& image) {
    const std::optional<std::size_t> stop = timed_ ? by_time(image) : by_number(image);
    if (!stop) {
      if (++outside_ == 1) {
        first_outside_ = image.path + (timed_ ? " (" + nearest_stop(stops_, image.number) + ")"
                                              : " (the recording has no such stop)");
      }
      return;
    }
    if (timed_ && image.stop && *image.stop != stops_[*stop].index && ++contradicting_ == 1) {
      first_contradicting_ = image.path + " (" + std::to_string(*image.stop) + ", but taken in stop " +
                             std::to_string(stops_[*stop].index) + ")";
    }
    placed_.push_back({*stop, &image});
  }

  [[nodiscard]] std::optional<std::size_t> by_time(const ListedImage& image) const {
    const double exposure_us = image.exposure_us.value_or(camera_.camera->exposure_us.value_or(0.0));
    constexpr double longest_us = 1e9;
    if (image.number > std::numeric_limits<std::int64_t>::max() / 2) return std::nullopt;
    const auto half_ns = static_cast<std::int64_t>(500.0 * std::min(exposure_us, longest_us));
    return stop_that_contains(stops_, image.number - half_ns, image.number + half_ns);
  }

  [[nodiscard]] std::optional<std::size_t> by_number(const ListedImage& image) const {
    if (!folder_.has_frames) return stop_of_index(stops_, image.number);
    return image.stop ? stop_of_index(stops_, *image.stop) : std::nullopt;
  }

  const Sensor& camera_;
  const ImageFolder& folder_;
  const std::vector<Stop>& stops_;
  bool timed_ = false;
  std::vector<Placed> placed_;
  std::size_t outside_ = 0;
  std::string first_outside_;
  std::size_t contradicting_ = 0;
  std::string first_contradicting_;
};

std::string size_text(int width, int height) { return std::to_string(width) + " x " + std::to_string(height); }

// The images of one stop.
StopOutcome read_stop(const std::vector<Placed>& images, const Sensor& camera, const RunContext& context) {
  StopImages stop(camera);
  for (const Placed& placed : images) {
    if (context.cancelled()) break;
    stop.add(placed.image->path, read_image(placed.image->path));
  }
  return {stop.take(static_cast<int>(images.front().stop)), stop.complaints()};
}

// The format of a camera's images may have become known only after they were read: a mosaic was taken for grey then.
bool is_as_told(const StopOutcome& outcome, const Sensor& camera) {
  return !outcome.image || outcome.image->image.pixel_format == camera.camera->pixel_format;
}

// The images that were placed, each stop's together.
std::vector<std::vector<Placed>> jobs_of(const Placing& placing) {
  std::map<std::size_t, std::vector<Placed>> by_stop;
  for (const Placed& placed : placing.placed()) by_stop[placed.stop].push_back(placed);
  std::vector<std::vector<Placed>> jobs;
  for (auto& [stop, images] : by_stop) jobs.push_back(std::move(images));
  return jobs;
}

std::vector<std::string> files_of(const std::vector<Placed>& images) {
  std::vector<std::string> files;
  for (const Placed& placed : images) files.push_back(placed.image->path);
  return files;
}

}  // namespace

std::string image_folder_of(const Sensor& camera, const std::vector<std::string>& places) {
  for (const std::string& place : places) {
    for (const std::string& name : {camera.name, camera.folder}) {
      std::error_code error;
      const std::string folder = (fs::path(place) / name).string();
      if (!name.empty() && fs::is_directory(folder, error)) return folder;
    }
  }
  return {};
}

std::string tell_of_unused(const std::string& folder, const ImageFolder& listed, Reporter& reporter) {
  if (!listed.torn.empty()) reporter.warn(listed.torn);
  const std::string hint = hint_of_unknown(folder, listed);
  const std::string mend = hint.empty() ? "" : "; " + hint;
  if (!listed.unknown.empty()) {
    const bool is_named_wrongly = std::any_of(listed.unknown.begin(), listed.unknown.end(), is_image_name);
    const char* files = is_named_wrongly ? "their names are no numbers" : "they are neither .png nor .jpg";
    reporter.warn(folder + ": " + std::to_string(listed.unknown.size()) + " files are not used, since " +
                  (listed.has_frames ? "frames.csv does not list them" : files) +
                  ", the first: " + listed.unknown.front() + mend);
  }
  return mend;
}

std::vector<std::optional<int>> stops_of_images(const ImageFolder& folder, const Sensor& camera,
                                                const std::vector<Stop>& stops) {
  std::vector<std::optional<int>> numbers(folder.images.size());
  const Placing placing(camera, folder, stops);
  for (const Placed& placed : placing.placed())
    numbers[static_cast<std::size_t>(placed.image - folder.images.data())] = stops[placed.stop].index;
  return numbers;
}

void StopImages::add(const std::string& name, const Expected<Image>& image) {
  if (!image) {
    Error error = image.error();
    if (error.where.empty()) error.where = name;
    complaints_.push_back(error.message());
    return;
  }
  const auto& wanted = camera_->camera->intrinsics;
  if (wanted && (image->width != wanted->width || image->height != wanted->height)) {
    complaints_.push_back(input_error("the image is " + size_text(image->width, image->height) +
                                          " pixels large, the intrinsics of " + camera_->name + " are for " +
                                          size_text(wanted->width, wanted->height),
                                      name, "give images as the camera took them, or intrinsics for their size")
                              .message());
  } else if (!mean_.add(*image)) {
    complaints_.push_back(
        input_error("has other channels or depth than " + first_, name, "leave one of them out").message());
  } else if (first_.empty()) {
    first_ = name;
  }
}

std::optional<StillImage> StopImages::take(int stop) const {
  if (mean_.count() == 0) return std::nullopt;
  StillImage out{stop, first_, mean_.mean()};
  if (out.image.pixel_format.empty()) out.image.pixel_format = camera_->camera->pixel_format;
  return out;
}

void conclude_images(const std::string& camera, const std::vector<std::string>& complaints, const RunContext& context,
                     StillImages& out) {
  constexpr std::size_t told = 3;
  if (complaints.empty()) return;
  if (out.images.empty()) {
    out.why_none = "none of its " + std::to_string(complaints.size()) + " images can be used: " + complaints.front();
    return;
  }
  for (std::size_t k = 0; k < std::min(told, complaints.size()); ++k) context.reporter.warn(complaints[k]);
  if (complaints.size() > told) {
    context.reporter.warn(camera + ": " + std::to_string(complaints.size() - told) +
                          " more of its images were left out likewise");
  }
}

StillImages read_still_images(const std::string& folder, const Sensor& camera, const std::vector<Stop>& stops,
                              const RunContext& context, StopImageCache* ahead) {
  StillImages out;
  const Expected<ImageFolder> listed = list_image_folder(folder);
  if (!listed) {
    out.why_none = listed.error().message();
    return out;
  }
  const std::string mend = tell_of_unused(folder, *listed, context.reporter);
  const Placing placing(camera, *listed, stops);
  placing.tell(context.reporter);
  if (placing.placed().empty()) {
    out.why_none = listed->images.empty() ? "its folder " + folder + " holds no images" + mend : placing.outside();
    return out;
  }
  const std::vector<std::vector<Placed>> jobs = jobs_of(placing);
  std::vector<StopOutcome> outcomes(jobs.size());
  parallel_for(jobs.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      std::optional<StopOutcome> known;
      if (ahead != nullptr) known = ahead->take(camera.name, jobs[k].front().stop, files_of(jobs[k]));
      outcomes[k] = known && is_as_told(*known, camera) ? std::move(*known) : read_stop(jobs[k], camera, context);
    }
  });
  std::vector<std::string> complaints;
  for (StopOutcome& outcome : outcomes) {
    complaints.insert(complaints.end(), outcome.complaints.begin(), outcome.complaints.end());
    if (outcome.image) out.images.push_back(std::move(*outcome.image));
  }
  conclude_images(camera.name, complaints, context, out);
  return out;
}

void read_images_ahead(const Rig& rig, const std::vector<Stop>& stops, const std::vector<std::string>& places,
                       StopImageCache& ahead, const std::stop_token& stop) {
  SilentReporter silent;
  for (const Sensor& camera : rig.sensors) {
    const std::string folder = camera.is_lidar() ? std::string() : image_folder_of(camera, places);
    if (folder.empty()) continue;
    const Expected<ImageFolder> listed = list_image_folder(folder);
    if (!listed) continue;
    const Placing placing(camera, *listed, stops);
    for (const std::vector<Placed>& images : jobs_of(placing)) {
      if (stop.stop_requested()) return;
      std::vector<std::string> files = files_of(images);
      if (ahead.has(camera.name, images.front().stop, files)) continue;
      StopOutcome outcome = read_stop(images, camera, {silent, {}});
      if (!outcome.complaints.empty() || !outcome.image) continue;
      const int halvings = camera.camera->intrinsics ? halvings_of(*camera.camera->intrinsics) : 0;
      outcome.image->features = std::make_shared<const ImageFeatures>(find_features(outcome.image->image, halvings));
      if (!ahead.keep(camera.name, images.front().stop, std::move(files), std::move(outcome))) return;
    }
  }
}

std::set<int> stops_with_images(const Rig& rig, const std::vector<std::string>& places) {
  std::set<int> stops;
  for (const Sensor& sensor : rig.sensors) {
    const std::string folder = sensor.is_lidar() ? std::string() : image_folder_of(sensor, places);
    if (folder.empty()) continue;
    // What is wrong with it is told when its images are read.
    const Expected<ImageFolder> listed = list_image_folder(folder);
    if (!listed) continue;
    for (const ListedImage& image : listed->images) {
      const std::int64_t stop = listed->has_frames ? image.stop.value_or(-1) : image.number;
      if (stop >= 0 && stop <= std::numeric_limits<int>::max()) stops.insert(static_cast<int>(stop));
    }
  }
  return stops;
}

std::vector<CameraRecording> camera_recordings(const Rig& rig, const std::vector<Stop>& stops,
                                               const std::vector<std::string>& places, const std::string& why_none,
                                               const std::shared_ptr<StopImageCache>& ahead) {
  std::vector<CameraRecording> out;
  for (std::size_t k = 0; k < rig.sensors.size(); ++k) {
    const Sensor& camera = rig.sensors[k];
    if (camera.is_lidar()) continue;
    const std::string found = image_folder_of(camera, places);
    CameraRecording recording{static_cast<int>(k), camera.initial_T_base_sensor, {}};
    recording.read_images = [found, camera, stops, why_none, ahead](const RunContext& context) {
      if (!found.empty()) return read_still_images(found, camera, stops, context, ahead.get());
      return StillImages{{}, why_none};
    };
    out.push_back(std::move(recording));
  }
  return out;
}

}  // namespace rigcal
