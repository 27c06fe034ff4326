#include "drivers/camera/aravis/aravis_camera.h"

#include <algorithm>

#include "core/base/seconds.h"
#include "core/rig/rig.h"
#include "drivers/camera/aravis/camera_setter.h"
#include "drivers/camera/aravis/device.h"
#include "drivers/camera/aravis/frame_stream.h"
#include "drivers/camera/aravis/settings_log.h"
#include "drivers/camera/aravis/usb_cameras.h"
#include "drivers/net/socket_limits.h"

namespace rigcal::camera {
namespace {

constexpr std::int64_t look_ns = 100'000'000;  ///< Between looks whether the camera is still there.
/// Between tries to have a lost camera again: each asks the network, and every second one all interfaces by broadcasts.
constexpr std::int64_t search_pause_ns = 300'000'000;

class AravisCamera final : public Camera {
 public:
  explicit AravisCamera(const AravisOptions& options) : Camera(search_pause_ns), options_(options) {}
  ~AravisCamera() override { close(); }
  AravisCamera(const AravisCamera&) = delete;
  AravisCamera& operator=(const AravisCamera&) = delete;

  [[nodiscard]] CameraCounters counters() const override;

 protected:
  Expected<CameraIdentity> do_open(const std::string& name) override;
  Expected<CameraSetup> do_configure(const CameraConfig& config) override;
  Expected<void> do_start() override;
  Expected<Delivery> do_next(std::int64_t timeout_ns) override;
  Expected<void> do_trigger() override;
  Expected<void> do_stop() override;
  void do_let_go() override;
  void do_close() override;

 private:
  void mend_what_was_left();
  void put_settings_back();
  void end_stream();
  Delivery deliver(Frame frame);
  /// The camera object made anew, where it is lost.
  Expected<void> reopen();
  /// Set up as before, after it was made anew.
  Expected<void> set_up_again();

  AravisOptions options_;
  CameraConfig config_;
  CameraSetup setup_;
  CameraIdentity wanted_;
  /// By its own register: not always what the bus tells in `wanted_` (FLIR's are decimal here and hexadecimal there).
  std::string own_serial_;
  SettingsLog log_;
  std::unique_ptr<Device> device_;  ///< None while it is lost.
  std::unique_ptr<FrameStream> stream_;
  bool searches_by_name_ = false;  ///< The next time.
};

/// Why a camera that Aravis does not see cannot be had, where the kernel sees it on the USB.
std::optional<Error> forbidden_usb_camera(const std::string& name) {
  for (const UsbCamera& camera : list_usb_cameras()) {
    const bool is_it = !camera.serial.empty() && name.find(camera.serial) != std::string::npos;
    if (!is_it || camera.is_allowed) continue;
    return system_error("this user may not open the camera's device file " + camera.node, name,
                        "install rigcal's udev rules, or add a rule with MODE=\"0666\" for it, and plug it in again");
  }
  return std::nullopt;
}

Expected<CameraIdentity> AravisCamera::do_open(const std::string& name) {
  std::string way = name;
  std::optional<CameraIdentity> known;
  if (!parse_ip(name)) {
    const auto there = AravisBackend(options_).enumerate();
    if (!there) return there.error();
    Expected<CameraIdentity> found = find_camera(*there, name);
    if (!found) {
      if (const auto forbidden = forbidden_usb_camera(name)) return *forbidden;
      return found;
    }
    way = found->address;
    known = *std::move(found);
  }
  Expected<std::unique_ptr<Device>> device = Device::open(way);
  if (!device) {
    if (known) return device.error();
    // An address that nobody answers at: who does, elsewhere?
    const auto there = AravisBackend(options_).enumerate();
    const auto found = there ? find_camera(*there, name) : Expected<CameraIdentity>(there.error());
    return found ? device.error() : found.error();
  }
  device_ = *std::move(device);
  wanted_ = known.value_or(device_->identity());
  own_serial_ = device_->identity().serial;
  mend_what_was_left();
  return wanted_;
}

void AravisCamera::mend_what_was_left() {
  const std::string file = settings_file(options_.settings_folder, wanted_.id);
  log_ = SettingsLog(file);
  const auto left = SettingsLog::read_left(file);
  if (!left) {
    note(left.error().message());
  } else if (!left->empty()) {
    if (device_->has("AcquisitionStop")) static_cast<void>(device_->execute("AcquisitionStop"));
    const std::vector<std::string> trouble = put_back(*device_, *left);
    note(wanted_.id +
         ": a program that used the camera did not end as it should; the settings from before it were put "
         "back");
    for (const std::string& what : trouble) note(what);
  }
  if (device_->answers()) log_.clear();
}

Expected<CameraSetup> AravisCamera::do_configure(const CameraConfig& config) {
  if (auto there = reopen(); !there) return there.error();
  put_settings_back();
  Expected<CameraSetup> setup = CameraSetter(*device_, log_).apply(config);
  if (log_.trouble()) note("the camera's settings are not kept in case of a crash: " + log_.trouble()->message());
  if (!setup) return setup;
  const auto largest = device_->is_gige() ? net::largest_receive_buffer() : std::nullopt;
  if (largest && *largest < options_.receive_bytes)
    setup->notes.push_back(net::receive_buffer_hint(options_.receive_bytes, *largest));
  config_ = config;
  setup_ = *setup;
  return setup;
}

Expected<void> AravisCamera::do_start() {
  const bool was_lost = !device_ || device_->is_lost();
  if (auto there = reopen(); !there) return there;
  if (was_lost) {
    if (auto done = set_up_again(); !done) return done;
  }
  auto stream = FrameStream::start(*device_, setup_, config_.buffers, options_);
  if (!stream) return stream.error();
  stream_ = *std::move(stream);
  return {};
}

Expected<Delivery> AravisCamera::do_next(std::int64_t timeout_ns) {
  const std::int64_t deadline_ns = monotonic_now_ns() + timeout_ns;
  while (true) {
    const std::int64_t left_ns = std::max<std::int64_t>(deadline_ns - monotonic_now_ns(), 0);
    if (std::optional<Frame> frame = stream_->next(std::min(left_ns, look_ns))) return deliver(std::move(*frame));
    // To end the stream of a camera that is gone takes Aravis seconds: first it is said, see `do_let_go`.
    if (device_->is_lost()) return lose(device_->is_usb() ? "it was unplugged" : "its heartbeat stopped");
    if (monotonic_now_ns() >= deadline_ns) return Delivery{};
  }
}

Delivery AravisCamera::deliver(Frame frame) {
  Delivery delivery;
  delivery.kind = Delivery::Kind::frame;
  ++counters_.frames[static_cast<std::size_t>(frame.facts().status)];
  counters_.missing += frame.facts().missing_before;
  delivery.frame = std::move(frame);
  return delivery;
}

Expected<void> AravisCamera::reopen() {
  if (device_ && !device_->is_lost()) return {};
  device_.reset();
  // First where it was; it may have another address by now.
  std::string way = wanted_.address;
  if (searches_by_name_ && !wanted_.serial.empty()) {
    const auto there = AravisBackend(options_).enumerate();
    const auto found = there ? find_camera(*there, wanted_.serial) : Expected<CameraIdentity>(there.error());
    if (!found) {
      searches_by_name_ = false;
      if (const auto forbidden = forbidden_usb_camera(wanted_.id)) return *forbidden;
      return found.error();
    }
    way = found->address;
  }
  searches_by_name_ = !searches_by_name_;
  Expected<std::unique_ptr<Device>> device = Device::open(way);
  if (!device) return device.error();
  if ((*device)->identity().serial != own_serial_) {
    return system_error("another camera is there, " + (*device)->identity().id, wanted_.id,
                        "give each camera an address of its own");
  }
  device_ = *std::move(device);
  searches_by_name_ = false;
  return {};
}

Expected<void> AravisCamera::set_up_again() {
  SettingsLog known_already;  // What was before us is in `log_`.
  CameraConfig config = config_;
  config.pixel_format = setup_.pixel_format;
  const auto setup = CameraSetter(*device_, known_already).apply(config);
  if (!setup) return setup.error();
  if (setup->width != setup_.width || setup->height != setup_.height)
    return system_error("the camera came back with another image size", wanted_.id, "set its part of the sensor");
  return {};
}

Expected<void> AravisCamera::do_trigger() { return device_->execute("TriggerSoftware"); }

Expected<void> AravisCamera::do_stop() {
  Expected<void> stopped;
  if (stream_ && device_ && !device_->is_lost()) stopped = stream_->stop(*device_);
  end_stream();
  return stopped;
}

void AravisCamera::do_let_go() {
  end_stream();
  device_.reset();
}

void AravisCamera::end_stream() {
  if (!stream_) return;
  stream_->abandon();
  const FrameStream::Counts counts = stream_->counts();
  counters_.discarded += counts.discarded;
  counters_.no_buffer += counts.no_buffer;
  counters_.resent_packets += counts.resent_packets;
  stream_.reset();
}

CameraCounters AravisCamera::counters() const {
  CameraCounters counters = counters_;  // Without those of the stream that runs.
  if (stream_) {
    const FrameStream::Counts counts = stream_->counts();
    counters.no_buffer += counts.no_buffer;
    counters.resent_packets += counts.resent_packets;
  }
  return counters;
}

// What does not answer keeps its entries, for the next time.
void AravisCamera::put_settings_back() {
  for (const std::string& what : put_back(*device_, log_.settings())) note(what);
  if (device_->answers()) log_.clear();
}

void AravisCamera::do_close() {
  if (device_ && !device_->is_lost() && device_->answers()) put_settings_back();
  if (!log_.settings().empty()) {
    note(wanted_.id + ": the camera is gone, so that its settings could not be put back");
    log_ = SettingsLog();  // The file stays, for the next time.
  }
  device_.reset();
  setup_ = {};
}

}  // namespace

std::unique_ptr<Camera> make_aravis_camera(const AravisOptions& options) {
  return std::make_unique<AravisCamera>(options);
}

}  // namespace rigcal::camera
