#include "drivers/camera/camera.h"

#include <algorithm>
#include <chrono>
#include <thread>

#include "core/base/seconds.h"
#include "core/base/text.h"

namespace rigcal::camera {
namespace {

constexpr std::size_t most_refusals = 20;  ///< That are told of one loss.

/// What no back end can do.
Expected<void> check_config(const CameraConfig& config) {
  const auto wrong = [](std::string what, std::string mend) {
    return system_error(std::move(what), {}, std::move(mend));
  };
  if (config.buffers < kFewestBuffers || config.buffers > kMostBuffers) {
    return wrong("a camera cannot have " + std::to_string(config.buffers) + " buffers", "give it 2 to 256");
  }
  if (config.region &&
      (config.region->width <= 0 || config.region->height <= 0 || config.region->x < 0 || config.region->y < 0)) {
    return wrong("the part of the sensor has no pixels or lies outside",
                 "give a size and an offset that are not below zero");
  }
  const auto is_bad = [](const std::optional<double>& value) { return value && !(*value > 0.0); };
  if (is_bad(config.exposure_us)) return wrong("the exposure is not above zero", "give microseconds");
  if (is_bad(config.frame_rate)) return wrong("the frame rate is not above zero", "give frames per second");
  if (config.trigger && config.trigger->source.empty()) {
    return wrong("the trigger has no source", "name a line of the camera, or Software");
  }
  if (config.trigger && !(config.trigger->delay_us >= 0.0)) {
    return wrong("the trigger's delay is below zero", "give microseconds");
  }
  return {};
}

std::string described(const CameraIdentity& camera) {
  std::string text = camera.id;
  if (!camera.serial.empty() && camera.id.find(camera.serial) == std::string::npos) {
    text += " (serial " + camera.serial + ")";
  }
  if (camera.address != camera.id) text += " at " + camera.address;
  return text;
}

}  // namespace

const char* to_string(FrameStatus status) {
  switch (status) {
    case FrameStatus::whole:
      return "whole";
    case FrameStatus::incomplete:
      return "incomplete";
    case FrameStatus::wrong_size:
      return "wrong size";
    case FrameStatus::device_error:
      return "device error";
    case FrameStatus::out_of_order:
      break;
  }
  return "out of order";
}

std::uint64_t CameraCounters::damaged() const {
  std::uint64_t sum = 0;
  for (std::size_t i = 1; i < frames.size(); ++i) sum += frames[i];
  return sum;
}

Expected<void> Camera::open(const std::string& name) {
  if (auto legal = check_call(CameraCall::open, state_); !legal) return legal;
  Expected<CameraIdentity> identity = do_open(name);
  if (!identity) return identity.error();
  identity_ = *std::move(identity);
  state_ = CameraState::open;
  return {};
}

Expected<CameraSetup> Camera::configure(const CameraConfig& config) {
  if (auto legal = check_call(CameraCall::configure, state_); !legal) return legal.error();
  if (auto sane = check_config(config); !sane)
    return Error{sane.error().kind, sane.error().what, identity_.id, sane.error().mend};
  state_ = CameraState::open;
  Expected<CameraSetup> setup = do_configure(config);
  if (!setup) return setup;
  config_ = config;
  state_ = CameraState::configured;
  return setup;
}

Expected<void> Camera::start() {
  if (auto legal = check_call(CameraCall::start, state_); !legal) return legal;
  if (auto started = do_start(); !started) return started;
  is_gone_ = false;
  state_ = CameraState::streaming;
  return {};
}

Expected<Delivery> Camera::next(std::int64_t timeout_ns) {
  if (auto legal = check_call(CameraCall::next, state_); !legal) return legal.error();
  const std::int64_t wait_ns = std::max<std::int64_t>(timeout_ns, 0);
  return is_gone_ ? search(wait_ns) : do_next(wait_ns);
}

Expected<void> Camera::trigger() {
  if (auto legal = check_call(CameraCall::trigger, state_); !legal) return legal;
  if (!config_.trigger || config_.trigger->source != "Software") {
    return system_error("the camera was not set up for triggers by software", identity_.id,
                        "set its trigger's source to Software");
  }
  if (is_gone_) return system_error(camera_is_gone, identity_.id, "wait until it is back");
  return do_trigger();
}

Expected<void> Camera::stop() {
  if (auto legal = check_call(CameraCall::stop, state_); !legal) return legal;
  state_ = CameraState::configured;
  return do_stop();
}

void Camera::close() {
  if (state_ == CameraState::streaming) {
    if (auto stopped = stop(); !stopped) note(stopped.error().message());
  }
  if (state_ != CameraState::closed) do_close();
  state_ = CameraState::closed;
}

Delivery Camera::lose(const std::string& how) {
  ++counters_.losses;
  is_gone_ = true;
  search_ns_ = monotonic_now_ns();
  refusals_.clear();
  Delivery delivery;
  delivery.kind = Delivery::Kind::lost;
  delivery.text = identity_.id + ": " + camera_is_gone + ": " + how;
  return delivery;
}

Delivery Camera::search(std::int64_t timeout_ns) {
  const std::int64_t deadline_ns = monotonic_now_ns() + timeout_ns;
  while (true) {
    if (monotonic_now_ns() >= search_ns_) {
      do_let_go();
      const auto started = do_start();
      if (started) return back();
      do_let_go();
      search_ns_ = monotonic_now_ns() + search_pause_ns_;
      if (auto delivery = refused(started.error())) return *std::move(delivery);
    }
    const std::int64_t left_ns = deadline_ns - monotonic_now_ns();
    if (left_ns <= 0) return {};
    const std::int64_t pause_ns = std::max<std::int64_t>(search_ns_ - monotonic_now_ns(), 0);
    std::this_thread::sleep_for(std::chrono::nanoseconds(std::min(left_ns, pause_ns)));
  }
}

std::optional<Delivery> Camera::refused(const Error& why) {
  if (why.what == no_such_camera || why.what == camera_is_gone) return std::nullopt;
  Error reason = why;
  if (reason.where == identity_.id) reason.where.clear();
  Delivery delivery;
  delivery.kind = Delivery::Kind::refused;
  delivery.text = identity_.id + ": the camera cannot be had again yet: " + reason.message();
  const bool was_told = std::find(refusals_.begin(), refusals_.end(), delivery.text) != refusals_.end();
  // A text that is another one each time is not told for ever.
  if (was_told || refusals_.size() == most_refusals) return std::nullopt;
  refusals_.push_back(delivery.text);
  return delivery;
}

Delivery Camera::back() {
  ++counters_.returns;
  is_gone_ = false;
  Delivery delivery;
  delivery.kind = Delivery::Kind::back;
  delivery.text = identity_.id + ": the camera is back";
  return delivery;
}

Expected<CameraIdentity> find_camera(const std::vector<CameraIdentity>& there, const std::string& name) {
  std::vector<CameraIdentity> found;
  std::vector<std::string> all;
  for (const CameraIdentity& camera : there) {
    const bool is_it = camera.id == name || camera.address == name || (!camera.serial.empty() && camera.serial == name);
    if (is_it) found.push_back(camera);
    all.push_back(described(camera));
  }
  if (found.size() == 1) return found[0];
  if (found.size() > 1) {
    std::vector<std::string> ids;
    for (const CameraIdentity& camera : found) ids.push_back(described(camera));
    return system_error("more than one camera has this name: " + list_text(ids), name, "name it by its address");
  }
  return system_error(no_such_camera, name,
                      all.empty() ? "no other is there either: look at its cable, its power and its address"
                                  : "there " + std::string(all.size() == 1 ? "is " : "are ") + list_text(all));
}

std::string list_text(const std::vector<std::string>& words) {
  if (words.empty()) return "none";
  std::string text = words[0];
  for (std::size_t i = 1; i < words.size(); ++i) text += (i + 1 == words.size() ? " and " : ", ") + words[i];
  return text;
}

}  // namespace rigcal::camera
