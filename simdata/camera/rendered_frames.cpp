#include "simdata/camera/rendered_frames.h"

#include <algorithm>
#include <utility>

namespace rigcal::sim {
namespace {

constexpr std::size_t pulses_ahead = 2;
constexpr std::size_t most_lights = 3;  // Of a camera; some 16 MB each.
constexpr std::size_t most_images = 4;

template <class Kept>
void keep(std::deque<Kept>& all, Kept made, std::size_t most) {
  all.push_back(std::move(made));
  if (all.size() > most) all.pop_front();
}

}  // namespace

RenderedFrames::RenderedFrames(const Scene& scene, const RayCaster& caster, const TurntableMotion& motion,
                               std::vector<SimulatedCamera> cameras, std::vector<ExposurePulse> pulses,
                               std::uint64_t seed)
    : motion_(motion), cameras_(std::move(cameras)), pulses_(std::move(pulses)), seed_(seed), units_(cameras_.size()) {
  for (std::size_t i = 0; i < cameras_.size(); ++i) {
    const ImageSensor& chip = cameras_[i].chip;
    units_[i].renderer = std::make_unique<ImageRenderer>(scene, caster, cameras_[i].model);
    units_[i].setting = {chip.format_name, chip.exposure_us, chip.gain_db};
  }
  thread_ = std::thread([this] { run(); });
}

RenderedFrames::~RenderedFrames() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

void RenderedFrames::set_wanted(std::size_t camera, bool wanted) {
  {
    const std::lock_guard lock(mutex_);
    if (units_[camera].is_wanted == wanted) return;
    units_[camera].is_wanted = wanted;
    if (!wanted) units_[camera].asked.reset();
  }
  changed_.notify_all();
}

void RenderedFrames::set_next(std::size_t pulse) {
  {
    const std::lock_guard lock(mutex_);
    if (next_ == pulse) return;
    next_ = pulse;
  }
  changed_.notify_all();
}

std::shared_ptr<const Image> RenderedFrames::frame(std::size_t camera, std::size_t pulse, const Setting& setting,
                                                   bool any_pulse) {
  std::shared_ptr<const Image> other;
  {
    const std::lock_guard lock(mutex_);
    Unit& unit = units_[camera];
    unit.setting = setting;
    for (const Made& made : unit.images) {
      if (made.setting != setting) continue;
      if (made.pulse == pulse) return made.image;
      other = made.image;
    }
    unit.asked = pulse;
  }
  changed_.notify_all();
  return any_pulse ? other : nullptr;
}

std::optional<RenderedFrames::Job> RenderedFrames::job_for(std::size_t camera, std::size_t pulse) const {
  const Unit& unit = units_[camera];
  const bool is_made = std::any_of(unit.images.begin(), unit.images.end(), [&](const Made& made) {
    return made.pulse == pulse && made.setting == unit.setting;
  });
  if (is_made) return std::nullopt;
  Job job{camera, pulse, unit.setting, nullptr};
  for (const Light& light : unit.lights) {
    if (light.pulse == pulse) job.light = light.field;
  }
  return job;
}

std::optional<RenderedFrames::Job> RenderedFrames::next_job() const {
  for (std::size_t i = 0; i < units_.size(); ++i) {
    if (!units_[i].asked) continue;
    if (auto job = job_for(i, *units_[i].asked)) return job;
  }
  for (std::size_t ahead = 0; ahead < std::min(pulses_ahead, pulses_.size()); ++ahead) {
    for (std::size_t i = 0; i < units_.size(); ++i) {
      if (!units_[i].is_wanted) continue;
      if (auto job = job_for(i, (next_ + ahead) % pulses_.size())) return job;
    }
  }
  return std::nullopt;
}

void RenderedFrames::run() {
  while (true) {
    std::optional<Job> job;
    {
      std::unique_lock lock(mutex_);
      changed_.wait(lock, [&] { return stop_ || (job = next_job()).has_value(); });
      if (stop_) return;
    }
    do_job(*std::move(job));
  }
}

void RenderedFrames::do_job(Job job) {
  const SimulatedCamera& camera = cameras_[job.camera];
  Unit& unit = units_[job.camera];
  if (!job.light) {
    const double middle_s = camera.middle_s(pulses_[job.pulse]);
    job.light = std::make_shared<const LightField>(
        unit.renderer->render(motion_.T_scene_base(middle_s) * camera.T_base_camera, middle_s));
    const std::lock_guard lock(mutex_);
    keep(unit.lights, {job.pulse, job.light}, most_lights);
  }
  ImageSensor chip = camera.chip;
  chip.format = parse_pixel_format(job.setting.pixel_format).value_or(chip.format);
  chip.format_name = job.setting.pixel_format;
  chip.exposure_us = job.setting.exposure_us;
  chip.gain_db = job.setting.gain_db;
  auto image = std::make_shared<const Image>(expose(*job.light, chip, seed_, camera.noise_of(job.pulse)));
  const std::lock_guard lock(mutex_);
  keep(unit.images, {job.pulse, std::move(job.setting), std::move(image)}, most_images);
  if (unit.asked == job.pulse) unit.asked.reset();
}

}  // namespace rigcal::sim
