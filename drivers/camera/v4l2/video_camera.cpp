#include "drivers/camera/v4l2/video_camera.h"

#include <linux/videodev2.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <functional>
#include <optional>
#include <thread>

#include "core/base/seconds.h"
#include "drivers/camera/frame_counter.h"
#include "drivers/camera/v4l2/video_backend.h"
#include "drivers/camera/v4l2/video_buffers.h"
#include "drivers/camera/v4l2/video_errors.h"
#include "drivers/camera/v4l2/video_setter.h"

namespace rigcal::camera {
namespace {

/// Between tries to have a lost camera again: each only opens the device files that are there, and is cheap.
constexpr std::int64_t search_pause_ns = 100'000'000;
constexpr std::int64_t dry_pause_ns = 1'000'000;  ///< Until somebody gives a buffer back.

void sleep_ns(std::int64_t time_ns) { std::this_thread::sleep_for(std::chrono::nanoseconds(time_ns)); }

template <std::size_t size>
std::string text_of(const std::uint8_t (&field)[size]) {
  const auto end = std::find(std::begin(field), std::end(field), std::uint8_t{0});
  return {std::begin(field), end};
}

class VideoCamera final : public Camera {
 public:
  explicit VideoCamera(std::shared_ptr<VideoKernel> kernel) : Camera(search_pause_ns), kernel_(std::move(kernel)) {}
  ~VideoCamera() override { close(); }
  VideoCamera(const VideoCamera&) = delete;
  VideoCamera& operator=(const VideoCamera&) = delete;

 protected:
  Expected<CameraIdentity> do_open(const std::string& name) override;
  Expected<CameraSetup> do_configure(const CameraConfig& config) override;
  Expected<void> do_start() override;
  Expected<Delivery> do_next(std::int64_t timeout_ns) override;
  Expected<void> do_trigger() override { return system_error("the camera has no trigger", wanted_.id); }
  Expected<void> do_stop() override;
  void do_let_go() override;
  void do_close() override;

 private:
  /// The camera may be one of those that this user may not open.
  [[nodiscard]] Error explain_absence(Error absent) const;
  /// Opened and set up where it is now, which may be another device file than before.
  Expected<CameraSetup> reopen(const std::function<Expected<CameraSetup>()>& set_up);
  Expected<void> open_at(const std::string& path);
  Expected<CameraSetup> set_up(const CameraConfig& config);
  /// Set up as before, after it was opened anew.
  Expected<CameraSetup> set_up_again();
  [[nodiscard]] HostStamp host_stamp() const;
  void stop_stream();
  /// A frame, an event, or nothing where it was not what it looked like.
  std::optional<Delivery> look(const VideoKernel::Ready& ready);
  std::optional<Delivery> take();
  bool has_source_changed() const;
  Delivery lose_at_once(const std::string& how);

  std::shared_ptr<VideoKernel> kernel_;
  CameraIdentity wanted_;
  std::shared_ptr<const VideoDevice> device_;
  std::unique_ptr<VideoSetter> setter_;
  std::shared_ptr<VideoBuffers> buffers_;
  CameraConfig config_;
  CameraSetup setup_;
  std::size_t row_bytes_ = 0;
  FrameCounter counter_{v4l2_sequence_numbers};
};

Expected<CameraIdentity> VideoCamera::do_open(const std::string& name) {
  const bool is_path = name.starts_with("/dev/");
  std::string path = name;
  if (!is_path) {
    const auto there = VideoBackend(kernel_).enumerate();
    if (!there) return there.error();
    Expected<CameraIdentity> found = find_camera(*there, name);
    if (!found) return explain_absence(found.error());
    path = found->address;
  }
  auto opened = open_video(kernel_, path);
  if (!opened) return opened.error();
  device_ = opened->device;
  wanted_ = opened->identity;
  setter_ = std::make_unique<VideoSetter>(device_);
  return wanted_;
}

Error VideoCamera::explain_absence(Error absent) const {
  std::vector<std::string> forbidden;
  for (const std::string& path : kernel_->devices()) {
    const int descriptor = kernel_->open(path);
    if (descriptor >= 0) kernel_->close(descriptor);
    if (descriptor == -EACCES || descriptor == -EPERM) forbidden.push_back(path);
  }
  if (forbidden.empty()) return absent;
  return system_error(absent.what + " among those that this user may open, " + list_text(forbidden) + " left out",
                      absent.where, video_error({}, {}, -EACCES).mend);
}

// More than one device file may have its name: those of its other sensors, or of a camera of the same kind whose maker
// gives all the same serial number. Where it was comes first; one that is held may be the wrong one.
Expected<CameraSetup> VideoCamera::reopen(const std::function<Expected<CameraSetup>()>& set_up) {
  const auto there = VideoBackend(kernel_).enumerate();
  if (!there) return there.error();
  std::vector<std::string> paths;
  for (const CameraIdentity& camera : *there) {
    if (camera.id != wanted_.id || camera.serial != wanted_.serial) continue;
    paths.insert(camera.address == wanted_.address ? paths.begin() : paths.end(), camera.address);
  }
  std::optional<Error> refusal;
  for (const std::string& path : paths) {
    const Expected<void> opened = open_at(path);
    Expected<CameraSetup> setup = opened ? set_up() : opened.error();
    if (setup) {
      wanted_.address = path;
      return setup;
    }
    do_let_go();
    if (!refusal) refusal = setup.error();
  }
  return refusal ? *refusal : explain_absence(system_error(no_such_camera, wanted_.id, "plug it in"));
}

Expected<void> VideoCamera::open_at(const std::string& path) {
  auto opened = open_video(kernel_, path);
  if (!opened) return opened.error();
  device_ = opened->device;
  setter_ = std::make_unique<VideoSetter>(device_);
  return {};
}

Expected<CameraSetup> VideoCamera::do_configure(const CameraConfig& config) {
  if (buffers_.use_count() > 1)
    return system_error("frames of the camera are still lent", wanted_.id, "give them back before it is set up anew");
  buffers_.reset();
  if (setter_) setter_->restore();
  Expected<CameraSetup> setup = device_ ? set_up(config) : reopen([&] { return set_up(config); });
  if (!setup) return setup;
  config_ = config;
  setup_ = *setup;
  return setup;
}

Expected<CameraSetup> VideoCamera::set_up(const CameraConfig& config) {
  Expected<CameraSetup> setup = setter_->apply(config);
  if (!setup) return setup;
  auto buffers = VideoBuffers::make(device_, config.buffers, setup->pixel_format);
  if (!buffers) return buffers.error();
  if ((*buffers)->smallest() < setup->image_bytes) {
    return system_error("the camera's buffers of " + std::to_string((*buffers)->smallest()) +
                            " bytes hold no image of " + std::to_string(setup->image_bytes),
                        wanted_.id, "choose another pixel format");
  }
  buffers_ = *std::move(buffers);
  setup->host_stamp = host_stamp();
  row_bytes_ = setter_->row_bytes();
  return setup;
}

/// What the driver for webcams calls the start of the exposure is when the first packet came, unless it is told to use
/// the cameras' own stamps.
HostStamp VideoCamera::host_stamp() const {
  if (!buffers_->stamps_exposure()) return HostStamp::arrival_end;
  if (wanted_.vendor != "uvcvideo") return HostStamp::exposure_start;
  const std::string uses_own = kernel_->parameter("uvcvideo", "hwtimestamps");
  return uses_own.empty() || uses_own == "0" ? HostStamp::arrival_start : HostStamp::exposure_start;
}

Expected<void> VideoCamera::do_start() {
  if (!device_) {
    if (auto there = reopen([this] { return set_up_again(); }); !there) return there.error();
  }
  v4l2_event_subscription change{};
  change.type = V4L2_EVENT_SOURCE_CHANGE;
  device_->control(VIDIOC_SUBSCRIBE_EVENT, &change);  // Webcams know no such thing.
  if (auto started = buffers_->start(); !started) return started;
  counter_ = FrameCounter(v4l2_sequence_numbers);
  return {};
}

Expected<CameraSetup> VideoCamera::set_up_again() {
  Expected<CameraSetup> setup = set_up(config_);
  if (!setup) return setup;
  if (setup->width != setup_.width || setup->height != setup_.height || setup->image_bytes != setup_.image_bytes)
    return system_error("the camera came back with another image size", wanted_.id, "set its size");
  return setup;
}

Expected<Delivery> VideoCamera::do_next(std::int64_t timeout_ns) {
  const std::int64_t deadline_ns = monotonic_now_ns() + timeout_ns;
  while (true) {
    const std::int64_t left_ns = std::max<std::int64_t>(deadline_ns - monotonic_now_ns(), 0);
    if (auto delivery = look(device_->wait(left_ns))) return std::move(*delivery);
    if (monotonic_now_ns() >= deadline_ns) return Delivery{};
  }
}

std::optional<Delivery> VideoCamera::look(const VideoKernel::Ready& ready) {
  if (ready.gone) return lose_at_once("it was unplugged");
  if (ready.event && has_source_changed()) return lose_at_once("what it sends has changed");
  if (ready.frame) return take();
  // The kernel also calls it an error where it has no buffer to fill.
  if (ready.error && buffers_->is_dry()) {
    sleep_ns(dry_pause_ns);
    return std::nullopt;
  }
  if (ready.error) return take();
  return std::nullopt;
}

std::optional<Delivery> VideoCamera::take() {
  VideoBuffers::Filled filled;
  if (const int code = buffers_->take(filled); code != 0) {
    if (code == -EAGAIN) return std::nullopt;
    return lose_at_once(code == -ENODEV ? "it was unplugged" : "its stream broke off");
  }
  FrameFacts facts;
  facts.status = filled.is_damaged                   ? FrameStatus::device_error
                 : filled.bytes < setup_.image_bytes ? FrameStatus::incomplete
                                                     : FrameStatus::whole;
  facts.frame_id = filled.sequence;
  facts.missing_before = counter_.missing_before(filled.sequence);
  facts.host_stamp_ns = filled.stamp_ns > 0 ? filled.stamp_ns : monotonic_now_ns();
  facts.width = setup_.width;
  facts.height = setup_.height;
  facts.row_bytes = row_bytes_;
  facts.pixel_format = buffers_->pixel_format();
  ++counters_.frames[static_cast<std::size_t>(facts.status)];
  counters_.missing += facts.missing_before;
  Delivery delivery;
  delivery.kind = Delivery::Kind::frame;
  const bool is_whole = facts.status == FrameStatus::whole;
  delivery.frame =
      Frame(facts, is_whole ? buffers_->bytes(filled.buffer, setup_.image_bytes) : ByteView(), buffers_, filled.buffer);
  return delivery;
}

bool VideoCamera::has_source_changed() const {
  bool has_changed = false;
  v4l2_event event{};
  while (device_->control(VIDIOC_DQEVENT, &event) == 0) {
    has_changed = has_changed || event.type == V4L2_EVENT_SOURCE_CHANGE;
    event = {};
  }
  return has_changed;
}

// Opened anew in any case: what was set may be gone with what happened.
Delivery VideoCamera::lose_at_once(const std::string& how) {
  stop_stream();
  do_let_go();
  return lose(how);
}

void VideoCamera::stop_stream() {
  if (buffers_) counters_.discarded += buffers_->stop();
}

Expected<void> VideoCamera::do_stop() {
  stop_stream();
  return {};
}

// While frames are lent the device takes no format: what it was before is put back when the last one comes.
void VideoCamera::do_close() {
  if (buffers_ && setter_)
    buffers_->set_at_end([setter = std::shared_ptr<VideoSetter>(std::move(setter_))] { setter->restore(); });
  do_let_go();
}

// Closed, with the settings that it had when it was opened.
void VideoCamera::do_let_go() {
  buffers_.reset();
  if (setter_) setter_->restore();
  setter_.reset();
  device_.reset();
}

}  // namespace

Expected<OpenVideo> open_video(const std::shared_ptr<VideoKernel>& kernel, const std::string& path) {
  const int descriptor = kernel->open(path);
  if (descriptor == -ENOENT) {
    std::vector<std::string> others = kernel->devices();
    return system_error(
        "there is no such device file", path,
        others.empty() ? "no camera of Video4Linux is there: plug it in" : "there is " + list_text(others));
  }
  if (descriptor < 0) return video_error("the camera cannot be opened", path, descriptor);
  auto device = std::make_shared<const VideoDevice>(kernel, descriptor, path);
  v4l2_capability what{};
  const int code = device->control(VIDIOC_QUERYCAP, &what);
  const std::uint32_t can = (what.capabilities & V4L2_CAP_DEVICE_CAPS) != 0 ? what.device_caps : what.capabilities;
  constexpr std::uint32_t needed = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING;
  if (code != 0 || (can & needed) != needed)
    return system_error("this is no camera that rigcal can use", path, "name another device file");
  CameraIdentity identity;
  identity.model = text_of(what.card);
  identity.vendor = text_of(what.driver);
  identity.serial = kernel->serial(path);
  identity.address = path;
  identity.link = "V4L2";
  // One word: the card, and what tells two of a kind apart.
  identity.id = identity.model + "-" + (identity.serial.empty() ? text_of(what.bus_info) : identity.serial);
  std::replace(identity.id.begin(), identity.id.end(), ' ', '-');
  return OpenVideo{std::move(device), std::move(identity)};
}

std::unique_ptr<Camera> make_video_camera(std::shared_ptr<VideoKernel> kernel) {
  return std::make_unique<VideoCamera>(std::move(kernel));
}

}  // namespace rigcal::camera
