#include "apps/recording/bag_images.h"

#include "apps/recording/bag_batches.h"
#include "apps/recording/ros_pixels.h"
#include "apps/recording/stamp_guess.h"
#include "apps/recording/still_images.h"
#include "core/base/seconds.h"
#include "core/base/text.h"

namespace rigcal {
namespace {

std::string seconds_text(std::int64_t ns) { return fixed_text(seconds_of_ns(ns), 3) + " s"; }

// Images come in the order of time, so those of one stop come together.
class BagImages {
 public:
  BagImages(const Sensor& camera, const std::vector<Stop>& stops, std::string path)
      : camera_(camera), stops_(stops), path_(std::move(path)), current_(camera) {}

  void take(const RecordedImage& image) {
    ++seen_;
    const auto half_ns = static_cast<std::int64_t>(500.0 * camera_.camera->exposure_us.value_or(0.0));
    const auto stop = stop_that_contains(stops_, image.stamp_ns - half_ns, image.stamp_ns + half_ns);
    if (!stop) {
      if (outside_ns_.empty())
        first_outside_ = seconds_text(image.stamp_ns) + " (" + nearest_stop(stops_, image.stamp_ns) + ")";
      outside_ns_.push_back(image.stamp_ns);
      return;
    }
    if (!stop_ || *stop_ != *stop) finish_stop();
    stop_ = stop;
    current_.add(path_ + ": the image of " + camera_.camera->topic + " at " + seconds_text(image.stamp_ns),
                 image_of(image.type, image.image));
  }

  StillImages finish(const RunContext& context) {
    finish_stop();
    const std::size_t outside = outside_ns_.size();
    if (out_.images.empty() && complaints_.empty()) {
      const std::string guess = guess_of_stamps(outside_ns_, stops_);
      out_.why_none = seen_ == 0 ? "the bag has no images on its topic '" + camera_.camera->topic +
                                       "'; check topic in the rig file, or give them by --images DIR"
                                 : "all of its " + std::to_string(seen_) +
                                       " images were taken outside of the stops, the first at " + first_outside_ +
                                       (guess.empty() ? guess : "; " + guess);
    }
    if (outside > 0 && outside < seen_) {
      context.reporter.warn(camera_.name + ": " + std::to_string(outside) + " of " + std::to_string(seen_) +
                            " images were taken outside of all stops and are not used, the first at " + first_outside_);
    }
    conclude_images(camera_.name, complaints_, context, out_);
    return std::move(out_);
  }

 private:
  void finish_stop() {
    if (!stop_) return;
    if (std::optional<StillImage> image = current_.take(static_cast<int>(*stop_))) {
      out_.images.push_back(std::move(*image));
    }
    const std::vector<std::string>& said = current_.complaints();
    complaints_.insert(complaints_.end(), said.begin(), said.end());
    current_ = StopImages(camera_);
    stop_.reset();
  }

  const Sensor& camera_;
  const std::vector<Stop>& stops_;
  std::string path_;
  StopImages current_;
  std::optional<std::size_t> stop_;
  std::uint64_t seen_ = 0;
  std::vector<std::int64_t> outside_ns_;  ///< The stamps of those outside of all stops.
  std::string first_outside_;
  std::vector<std::string> complaints_;
  StillImages out_;
};

StillImages read_bag_images(const std::string& path, const Sensor& camera, const std::vector<Stop>& stops,
                            const RunContext& context) {
  if (camera.camera->topic.empty()) {
    return {{}, "the rig file has no topic for it; add topic: /name/of/its/images, or give them by --images DIR"};
  }
  Rig alone;  // so that nothing else of the bag is decoded
  alone.sensors.push_back(camera);
  BagImages images(camera, stops, path);
  BatchSinks sinks;
  sinks.images = [&](const RecordedImage& image) { images.take(image); };
  const Expected<std::unique_ptr<BatchSource>> bag = open_bag_batches(path, alone, std::move(sinks));
  if (!bag) return {{}, bag.error().message()};
  while (!context.cancelled()) {
    const Expected<bool> more = (*bag)->read_some();
    if (!more) return {{}, more.error().message()};
    if (!*more) break;
    context.reporter.progress(camera.name, (*bag)->fraction());
  }
  return images.finish(context);
}

}  // namespace

std::vector<CameraRecording> bag_camera_recordings(const Rig& rig, const std::vector<Stop>& stops,
                                                   const std::string& path) {
  std::vector<CameraRecording> out;
  for (std::size_t k = 0; k < rig.sensors.size(); ++k) {
    const Sensor& camera = rig.sensors[k];
    if (camera.is_lidar()) continue;
    out.push_back({static_cast<int>(k), camera.initial_T_base_sensor, [path, camera, stops](const RunContext& context) {
                     return read_bag_images(path, camera, stops, context);
                   }});
  }
  return out;
}

}  // namespace rigcal
