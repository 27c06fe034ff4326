#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "simdata/camera/camera_shots.h"
#include "simdata/camera/image_renderer.h"
#include "simdata/camera/image_sensor.h"
#include "simdata/rig/turntable_motion.h"

namespace rigcal::sim {

/// Renders what the cameras of a run see at its exposures, in a thread of its own: a little ahead of the run where a
/// camera is wanted, and what is asked for first. The same pixels as in the run's session, where a camera is set as in
/// the rig file.
class RenderedFrames {
 public:
  /// What is passed by reference must outlive this. At least one pulse.
  RenderedFrames(const Scene& scene, const RayCaster& caster, const TurntableMotion& motion,
                 std::vector<SimulatedCamera> cameras, std::vector<ExposurePulse> pulses, std::uint64_t seed);
  ~RenderedFrames();
  RenderedFrames(const RenderedFrames&) = delete;
  RenderedFrames& operator=(const RenderedFrames&) = delete;

  /// Whether to work ahead for a camera.
  void set_wanted(std::size_t camera, bool wanted);
  /// The pulse that comes next: work ahead begins with it.
  void set_next(std::size_t pulse);

  /// How a camera is set for a frame.
  struct Setting {
    std::string pixel_format;
    double exposure_us = 0.0;
    double gain_db = 0.0;
    bool operator==(const Setting&) const = default;
  };
  /// What a camera sees at a pulse, the whole sensor; nothing where it is not rendered yet. `any_pulse`: rather the
  /// latest one that is there than nothing.
  [[nodiscard]] std::shared_ptr<const Image> frame(std::size_t camera, std::size_t pulse, const Setting& setting,
                                                   bool any_pulse);

  [[nodiscard]] const std::vector<SimulatedCamera>& cameras() const { return cameras_; }
  [[nodiscard]] const std::vector<ExposurePulse>& pulses() const { return pulses_; }

 private:
  struct Light {
    std::size_t pulse = 0;
    std::shared_ptr<const LightField> field;
  };
  struct Made {
    std::size_t pulse = 0;
    Setting setting;
    std::shared_ptr<const Image> image;
  };
  struct Unit {
    std::unique_ptr<ImageRenderer> renderer;
    bool is_wanted = false;
    std::optional<std::size_t> asked;  ///< A pulse that somebody waits for.
    Setting setting;                   ///< As it was asked for last.
    std::deque<Light> lights;          ///< The latest last.
    std::deque<Made> images;
  };
  struct Job {
    std::size_t camera = 0;
    std::size_t pulse = 0;
    Setting setting;
    std::shared_ptr<const LightField> light;  ///< Nothing: it has to be rendered first.
  };

  void run();
  [[nodiscard]] std::optional<Job> next_job() const;
  [[nodiscard]] std::optional<Job> job_for(std::size_t camera, std::size_t pulse) const;
  void do_job(Job job);

  const TurntableMotion& motion_;
  std::vector<SimulatedCamera> cameras_;
  std::vector<ExposurePulse> pulses_;
  std::uint64_t seed_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<Unit> units_;
  std::size_t next_ = 0;
  bool stop_ = false;
  std::thread thread_;
};

}  // namespace rigcal::sim
