#include "simdata/live/live_cameras.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/seconds.h"
#include "core/records/pixel_format.h"
#include "simdata/camera/camera_shots.h"
#include "simdata/gige/test_pattern.h"
#include "simdata/live/camera_units.h"

namespace rigcal::sim {
namespace {

constexpr std::int64_t pulses_ahead_ns = 1'000'000'000;
constexpr std::int64_t look_ns = 100'000'000;

/// The part of an image that a camera was told to send, as it goes over the wire.
void cut_out(const Image& image, const FrameWish& wish, PixelLayout layout, std::vector<std::uint8_t>& out) {
  const auto pixel_bytes = static_cast<std::size_t>(image.channels * image.bits / 8);
  const std::size_t row_bytes = static_cast<std::size_t>(wish.width) * pixel_bytes;
  out.resize(row_bytes * static_cast<std::size_t>(wish.height));
  for (int y = 0; y < wish.height; ++y) {
    const std::size_t from = static_cast<std::size_t>(wish.offset_y + y) * image.row_bytes() +
                             static_cast<std::size_t>(wish.offset_x) * pixel_bytes;
    std::copy_n(image.bytes.begin() + static_cast<std::ptrdiff_t>(from), row_bytes,
                out.begin() + static_cast<std::ptrdiff_t>(static_cast<std::size_t>(y) * row_bytes));
  }
  if (layout != PixelLayout::bgr) return;
  // An image has red first.
  const std::size_t value_bytes = pixel_bytes / 3;
  for (std::size_t i = 0; i < out.size(); i += pixel_bytes)
    std::swap_ranges(out.begin() + static_cast<std::ptrdiff_t>(i),
                     out.begin() + static_cast<std::ptrdiff_t>(i + value_bytes),
                     out.begin() + static_cast<std::ptrdiff_t>(i + 2 * value_bytes));
}

}  // namespace

/// What a camera sees at the run's exposure that is nearest to a frame's.
class LiveCameras::Source final : public FrameSource {
 public:
  Source(std::shared_ptr<RenderedFrames> frames, std::shared_ptr<const Clock> clock, std::size_t camera,
         double duration_s)
      : frames_(std::move(frames)), clock_(std::move(clock)), camera_(camera), duration_s_(duration_s) {}

  bool make(const FrameWish& wish, std::vector<std::uint8_t>& out) override {
    // Whoever triggers wants that exposure; a camera that runs freely shows what there is.
    const auto image = frames_->frame(camera_, nearest(wish.start_ns),
                                      {wish.pixel_format, wish.exposure_us, wish.gain_db}, !wish.pulse);
    if (!image) return false;
    const auto format = parse_pixel_format(wish.pixel_format).value_or(PixelFormat{});
    cut_out(*image, wish, format.layout, out);
    return true;
  }

 private:
  std::size_t nearest(std::int64_t time_ns) const {
    const std::int64_t start_ns = clock_->start_ns;
    if (time_ns <= start_ns) return 0;
    const double time_s =
        std::fmod(seconds_of_ns(time_ns - start_ns) * clock_->speed, duration_s_) - frames_->cameras()[camera_].delay_s;
    const std::vector<ExposurePulse>& pulses = frames_->pulses();
    const auto nearer = [time_s](const ExposurePulse& a, const ExposurePulse& b) {
      return std::abs(a.time_s - time_s) < std::abs(b.time_s - time_s);
    };
    return static_cast<std::size_t>(std::min_element(pulses.begin(), pulses.end(), nearer) - pulses.begin());
  }

  std::shared_ptr<RenderedFrames> frames_;
  std::shared_ptr<const Clock> clock_;
  std::size_t camera_;
  double duration_s_;
};

Expected<std::unique_ptr<LiveCameras>> LiveCameras::start(const Scene& scene, const RayCaster& caster, const Rig& rig,
                                                          const SimulatedRig& simulated, const RunOptions& run,
                                                          const LiveCameraOptions& options,
                                                          std::vector<Incident> incidents) {
  std::unique_ptr<LiveCameras> made(new LiveCameras);
  auto cameras = simulated_cameras(rig, simulated.T_base_sensor);
  if (!cameras) return cameras.error();
  made->pulses_ = plan_exposures(*cameras, simulated.motion, run.images_per_stop);
  std::erase_if(*cameras, [&rig](const SimulatedCamera& camera) {
    return !is_served(rig.sensors[static_cast<std::size_t>(camera.sensor)]);
  });
  if (made->pulses_.empty()) cameras->clear();
  const auto addresses = camera_addresses(rig);
  if (!addresses) return addresses.error();
  made->duration_s_ = simulated.motion.duration_s();
  made->has_own_pulses_ = options.trigger_port == 0;
  if (rig.trigger) made->pulse_s_ = 1e-6 * rig.trigger->pulse_us;
  made->switched_on_ns_ = monotonic_now_ns();
  if (!cameras->empty() && !options.is_test_pattern)
    made->frames_ =
        std::make_shared<RenderedFrames>(scene, caster, simulated.motion, *cameras, made->pulses_, run.seed);
  std::vector<ServedCamera> served;
  for (const SimulatedCamera& camera : *cameras) {
    const Sensor& sensor = rig.sensors[static_cast<std::size_t>(camera.sensor)];
    const gige::Ipv4 ip = (*addresses)[static_cast<std::size_t>(camera.sensor)];
    auto formats = camera_formats(sensor);
    if (!formats) return formats.error();
    const ClockTruth clock = camera_clock(run.seed, camera.sensor);
    ServedCamera unit;
    unit.device.identity = camera_identity(sensor, ip);
    unit.device.width = sensor.camera->intrinsics->width;
    unit.device.height = sensor.camera->intrinsics->height;
    unit.device.pixel_formats = *std::move(formats);
    unit.device.exposure_us = camera.chip.exposure_us;
    unit.device.gain_db = camera.chip.gain_db;
    unit.device.clock_start_ns = clock.offset_ns;
    unit.device.clock_drift = clock.drift_ppm * 1e-6;
    unit.device.can_resend = options.can_resend;
    unit.device.answer_delay_s = options.answer_delay_s;
    unit.faults = options.faults;
    if (options.is_test_pattern) {
      unit.source = std::make_shared<TestPattern>();
    } else {
      unit.source = std::make_shared<Source>(made->frames_, made->clock_, served.size(), made->duration_s_);
    }
    for (const Incident& incident : incidents) {
      if (incident.sensor == camera.name) made->events_.push_back({incident, served.size()});
    }
    made->units_.push_back({camera.name, ip});
    served.push_back(std::move(unit));
  }
  if (served.empty()) return made;
  auto server = CameraServer::start(std::move(served), {options.trigger_port, run.seed, {}});
  if (!server) return server.error();
  made->server_ = *std::move(server);
  return made;
}

void LiveCameras::begin(std::int64_t start_ns, double speed, bool repeat) {
  repeats_ = repeat;
  clock_->speed = speed;
  clock_->start_ns = start_ns;
}

void LiveCameras::tick(std::int64_t now_ns) {
  if (!server_) return;
  happen(now_ns);
  if (now_ns - look_ns >= looked_ns_ && frames_) {
    looked_ns_ = now_ns;
    const std::vector<CameraCounts> counts = server_->counts();
    for (std::size_t i = 0; i < counts.size(); ++i) frames_->set_wanted(i, counts[i].is_acquiring);
  }
  give_pulses(now_ns);
}

void LiveCameras::give_pulses(std::int64_t now_ns) {
  const std::int64_t start_ns = clock_->start_ns;
  if (start_ns == INT64_MAX) return;
  const auto time_of = [&](std::uint64_t number) {
    const auto run = static_cast<double>(number / pulses_.size());
    const double time_s = run * duration_s_ + pulses_[number % pulses_.size()].time_s;
    return start_ns + ns_of_seconds(time_s / clock_->speed);
  };
  while ((repeats_ || given_ < pulses_.size()) && time_of(given_) <= now_ns + pulses_ahead_ns) {
    const std::int64_t rise_ns = time_of(given_);
    if (has_own_pulses_)
      server_->pulse({0, rise_ns, rise_ns + ns_of_seconds(pulse_s_), static_cast<std::int64_t>(given_)});
    ++given_;
    if (frames_) frames_->set_next((given_ + pulses_.size() - 1) % pulses_.size());
  }
}

void LiveCameras::happen(std::int64_t now_ns) {
  for (Event& event : events_) {
    const auto at = [this](double time_s) { return switched_on_ns_ + ns_of_seconds(time_s); };
    const Incident& incident = event.incident;
    const std::int64_t end_ns = at(incident.time_s + incident.length_s);
    if (!event.has_begun && now_ns >= at(incident.time_s)) {
      event.has_begun = true;
      if (incident.kind == Incident::Kind::reboot) server_->reboot(event.camera);
      if (incident.kind == Incident::Kind::silence) server_->fall_silent(event.camera, end_ns);
      if (incident.kind == Incident::Kind::owned_by_other) server_->set_owned_by_other(event.camera, true);
    }
    if (event.has_begun && !event.has_ended && now_ns >= end_ns) {
      event.has_ended = true;
      if (incident.kind == Incident::Kind::owned_by_other) server_->set_owned_by_other(event.camera, false);
    }
  }
}

bool LiveCameras::is_any_acquiring() const {
  if (!server_) return false;
  const auto counts = server_->counts();
  return std::any_of(counts.begin(), counts.end(), [](const CameraCounts& camera) { return camera.is_acquiring; });
}

bool LiveCameras::is_idle() const {
  if (!server_) return true;
  const auto counts = server_->counts();
  return std::all_of(counts.begin(), counts.end(), [](const CameraCounts& camera) { return camera.is_idle; });
}

std::vector<LiveCameraSummary> LiveCameras::summary() const {
  std::vector<LiveCameraSummary> all;
  if (!server_) return all;
  const std::vector<CameraCounts> counts = server_->counts();
  for (std::size_t i = 0; i < units_.size(); ++i) all.push_back({units_[i].name, units_[i].ip, counts[i]});
  return all;
}

}  // namespace rigcal::sim
