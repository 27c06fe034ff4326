#include "drivers/camera/images/image_camera.h"

#include <algorithm>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <thread>

#include "core/base/seconds.h"
#include "core/io/image_file.h"
#include "core/io/image_folder.h"
#include "core/records/pixel_format.h"
#include "drivers/camera/frame_pool.h"

namespace rigcal::camera {
namespace {

namespace fs = std::filesystem;
using Pace = ImageCameraOptions::Pace;

/// Numbers of files from here on are stamps (17 minutes after 1970 and later), smaller ones count stops.
constexpr std::int64_t smallest_stamp_ns = 1'000'000'000'000;

void sleep_until(std::int64_t time_ns) {
  std::this_thread::sleep_until(std::chrono::steady_clock::time_point(std::chrono::nanoseconds(time_ns)));
}

CameraIdentity identity_of(const fs::path& folder) {
  CameraIdentity identity;
  const fs::path whole = folder.lexically_normal();
  identity.id = (whole.has_filename() ? whole : whole.parent_path()).filename().string();
  identity.address = folder.string();
  identity.model = "folder of images";
  identity.link = "images";
  return identity;
}

/// The sensor's own format: what an image is before anybody says more of it.
std::string plain_format(const Image& image) {
  return (image.channels == 3 ? "RGB" : "Mono") + std::to_string(image.bits);
}

std::vector<std::string> formats_of(const Image& image) {
  if (image.channels == 3) return {plain_format(image)};
  std::vector<std::string> names;
  for (const char* layout : {"Mono", "BayerRG", "BayerGR", "BayerGB", "BayerBG"}) {
    for (const int bits : {8, 10, 12, 14, 16}) {
      if ((bits == 8) == (image.bits == 8)) names.push_back(layout + std::to_string(bits));
    }
  }
  return names;
}

Expected<std::vector<CameraIdentity>> folders_in(const std::string& root) {
  std::vector<CameraIdentity> cameras;
  if (root.empty()) return cameras;
  std::error_code error;
  fs::directory_iterator entries(root, error);
  if (error) return system_error("the folder of the cameras' images cannot be read", root, "look at its name");
  for (const fs::directory_entry& entry : entries) {
    if (!entry.is_directory(error)) continue;
    const Expected<ImageFolder> images = list_image_folder(entry.path().string());
    if (images && !images->images.empty()) cameras.push_back(identity_of(entry.path()));
  }
  std::sort(cameras.begin(), cameras.end(),
            [](const CameraIdentity& a, const CameraIdentity& b) { return a.id < b.id; });
  return cameras;
}

class ImageCamera final : public Camera {
 public:
  explicit ImageCamera(ImageCameraOptions options) : options_(std::move(options)) {}
  ~ImageCamera() override { close(); }
  ImageCamera(const ImageCamera&) = delete;
  ImageCamera& operator=(const ImageCamera&) = delete;

 protected:
  Expected<CameraIdentity> do_open(const std::string& name) override;
  Expected<CameraSetup> do_configure(const CameraConfig& config) override;
  Expected<void> do_start() override;
  Expected<Delivery> do_next(std::int64_t timeout_ns) override;
  Expected<void> do_trigger() override {
    ++triggers_;
    return {};
  }
  Expected<void> do_stop() override { return {}; }
  void do_close() override { pool_.reset(); }

 private:
  [[nodiscard]] bool is_triggered() const { return config_.trigger && config_.trigger->source == "Software"; }
  /// Whether the images come at times of their own.
  [[nodiscard]] bool is_paced() const { return config_.frame_rate || (has_stamps_ && options_.pace == Pace::recorded); }
  [[nodiscard]] std::int64_t due_ns(std::size_t image) const;
  void skip();
  Delivery deliver(std::size_t buffer);
  [[nodiscard]] FrameStatus load(const ListedImage& listed, std::span<std::uint8_t> out) const;

  ImageCameraOptions options_;
  CameraConfig config_;
  std::vector<ListedImage> images_;
  bool has_stamps_ = false;
  Image first_;    ///< Without its pixels: what all images should be.
  Region region_;  ///< Of the images.
  CameraSetup setup_;
  std::shared_ptr<FramePool> pool_;
  std::size_t next_ = 0;
  std::uint64_t skipped_ = 0;  ///< Since the last frame.
  std::uint64_t triggers_ = 0;
  std::int64_t started_ns_ = 0;
  bool has_ended_ = false;
};

Expected<CameraIdentity> ImageCamera::do_open(const std::string& name) {
  std::error_code error;
  CameraIdentity identity;
  if (fs::is_directory(name, error)) {
    identity = identity_of(name);
  } else {
    const Expected<std::vector<CameraIdentity>> there = folders_in(options_.folder);
    if (!there) return there.error();
    Expected<CameraIdentity> found = find_camera(*there, name);
    if (!found) return found;
    identity = *std::move(found);
  }
  Expected<ImageFolder> folder = list_image_folder(identity.address);
  if (!folder) return system_error(folder.error().what, folder.error().where, folder.error().mend);
  if (folder->images.empty())
    return system_error("there are no images in the folder", identity.address, "name another one");
  images_ = std::move(folder->images);
  has_stamps_ = folder->has_frames || images_.front().number >= smallest_stamp_ns;
  // The first that can be read says what the others have to be.
  std::optional<Error> unread;
  for (const ListedImage& listed : images_) {
    Expected<Image> image = read_image(listed.path);
    if (image) {
      first_ = *std::move(image);
      first_.bytes = {};
      return identity;
    }
    if (!unread) unread = system_error(image.error().what, image.error().where, image.error().mend);
  }
  return *unread;
}

Expected<CameraSetup> ImageCamera::do_configure(const CameraConfig& config) {
  setup_ = {};
  const std::vector<std::string> formats = formats_of(first_);
  setup_.pixel_format = config.pixel_format.empty() ? plain_format(first_) : config.pixel_format;
  if (std::find(formats.begin(), formats.end(), setup_.pixel_format) == formats.end()) {
    return system_error("the images cannot be " + setup_.pixel_format, identity().address,
                        "they can be " + list_text(formats));
  }
  region_ = config.region.value_or(Region{0, 0, first_.width, first_.height});
  if (region_.x > first_.width - region_.width || region_.y > first_.height - region_.height) {
    return system_error("the images have no part of " + std::to_string(region_.width) + " x " +
                            std::to_string(region_.height) + " pixels there",
                        identity().address,
                        "they are of " + std::to_string(first_.width) + " x " + std::to_string(first_.height));
  }
  setup_.width = region_.width;
  setup_.height = region_.height;
  setup_.image_bytes = static_cast<std::size_t>(region_.width) * static_cast<std::size_t>(region_.height) *
                       static_cast<std::size_t>(first_.channels * first_.bits / 8);
  setup_.frame_rate = config.frame_rate;
  setup_.has_device_stamps = has_stamps_;
  if (config.exposure_us || config.gain) setup_.notes.push_back("images in a folder take no exposure and no gain");
  if (config.trigger && config.trigger->source != "Software") {
    setup_.notes.push_back("images in a folder follow no line: they come at their own times");
  }
  config_ = config;
  pool_ = std::make_shared<FramePool>(config.buffers, setup_.image_bytes, setup_.pixel_format);
  return setup_;
}

Expected<void> ImageCamera::do_start() {
  next_ = 0;
  skipped_ = 0;
  triggers_ = 0;
  has_ended_ = false;
  started_ns_ = monotonic_now_ns();
  return {};
}

std::int64_t ImageCamera::due_ns(std::size_t image) const {
  if (config_.frame_rate)
    return started_ns_ + static_cast<std::int64_t>(static_cast<double>(image) * 1e9 / *config_.frame_rate);
  return started_ns_ + (images_[image].number - images_.front().number);
}

void ImageCamera::skip() {
  ++next_;
  ++skipped_;
  ++counters_.no_buffer;
  ++counters_.missing;
}

Expected<Delivery> ImageCamera::do_next(std::int64_t timeout_ns) {
  constexpr std::int64_t look_again_ns = 1'000'000;  // For a buffer that is given back by another thread.
  const std::int64_t deadline_ns = monotonic_now_ns() + timeout_ns;
  while (true) {
    Delivery delivery;
    if (next_ == images_.size()) {
      if (!has_ended_) {
        has_ended_ = true;
        delivery.kind = Delivery::Kind::ended;
        return delivery;
      }
      sleep_until(deadline_ns);
      return delivery;
    }
    if (is_triggered() && triggers_ == 0) {
      sleep_until(deadline_ns);
      return delivery;
    }
    if (!is_triggered() && is_paced()) {
      // As with a camera, so many wait as there are buffers, and no more.
      while (next_ + config_.buffers < images_.size() && due_ns(next_ + config_.buffers) <= monotonic_now_ns()) skip();
      if (due_ns(next_) > deadline_ns) {
        sleep_until(deadline_ns);
        return delivery;
      }
      sleep_until(due_ns(next_));
    }
    if (is_triggered()) --triggers_;
    if (const std::optional<std::size_t> buffer = pool_->take()) return deliver(*buffer);
    if (is_triggered() || is_paced()) {
      skip();
    } else if (monotonic_now_ns() >= deadline_ns) {
      return delivery;
    } else {
      sleep_until(monotonic_now_ns() + look_again_ns);
    }
  }
}

Delivery ImageCamera::deliver(std::size_t buffer) {
  const ListedImage& listed = images_[next_];
  const std::span<std::uint8_t> bytes = pool_->bytes(buffer);
  FrameFacts facts;
  facts.host_stamp_ns = monotonic_now_ns();
  facts.status = load(listed, bytes);
  facts.frame_id = next_++;
  facts.missing_before = std::exchange(skipped_, 0);
  if (has_stamps_) facts.device_stamp_ns = listed.number;
  facts.exposure_us = listed.exposure_us;
  facts.width = setup_.width;
  facts.height = setup_.height;
  facts.row_bytes = bytes.size() / static_cast<std::size_t>(setup_.height);
  facts.pixel_format = pool_->pixel_format();
  ++counters_.frames[static_cast<std::size_t>(facts.status)];
  Delivery delivery;
  delivery.kind = Delivery::Kind::frame;
  const ByteView pixels = facts.status == FrameStatus::whole ? ByteView(bytes) : ByteView();
  delivery.frame = Frame(facts, pixels, pool_, buffer);
  return delivery;
}

FrameStatus ImageCamera::load(const ListedImage& listed, std::span<std::uint8_t> out) const {
  const Expected<Image> image = read_image(listed.path);
  if (!image) return FrameStatus::device_error;
  if (image->width != first_.width || image->height != first_.height || image->channels != first_.channels ||
      image->bits != first_.bits) {
    return FrameStatus::wrong_size;
  }
  const std::size_t row_bytes = out.size() / static_cast<std::size_t>(region_.height);
  const std::size_t left =
      static_cast<std::size_t>(region_.x) * image->row_bytes() / static_cast<std::size_t>(image->width);
  for (int row = 0; row < region_.height; ++row) {
    std::memcpy(out.data() + static_cast<std::size_t>(row) * row_bytes,
                image->bytes.data() + static_cast<std::size_t>(region_.y + row) * image->row_bytes() + left, row_bytes);
  }
  return FrameStatus::whole;
}

}  // namespace

Expected<std::vector<CameraIdentity>> ImageBackend::enumerate() { return folders_in(options_.folder); }

std::unique_ptr<Camera> ImageBackend::make() { return std::make_unique<ImageCamera>(options_); }

}  // namespace rigcal::camera
