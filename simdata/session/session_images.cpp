#include "simdata/session/session_images.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>

#include "core/base/seconds.h"
#include "core/io/frame_files.h"
#include "core/io/image_file.h"
#include "core/io/output_file.h"
#include "simdata/camera/camera_shots.h"
#include "simdata/camera/image_renderer.h"
#include "simdata/rig/light_rig.h"

namespace rigcal::sim {
namespace {

namespace fs = std::filesystem;

// Tells how many images of all are done, and whether to go on.
class ImageCount {
 public:
  ImageCount(std::size_t images, const RunContext& context) : images_(images), context_(context) {}
  Expected<void> add() {
    ++done_;
    context_.reporter.progress("render images", static_cast<double>(done_) / static_cast<double>(images_));
    if (context_.cancelled()) return cancelled_error();
    return {};
  }
  [[nodiscard]] std::uint64_t done() const { return done_; }

 private:
  std::size_t images_;
  const RunContext& context_;
  std::uint64_t done_ = 0;
};

Expected<void> write_frame(const ImageRenderer& renderer, const SimulatedCamera& camera, const SE3& T_scene_base,
                           double time_s, std::uint64_t seed, std::uint64_t frame, const std::string& path) {
  const LightField light = renderer.render(T_scene_base * camera.T_base_camera, time_s);
  return write_image(path, expose(light, camera.chip, seed, camera.noise_of(frame)));
}

Expected<void> write_camera(const Scene& scene, const RayCaster& caster, const SimulatedCamera& camera,
                            const SimulatedRig& simulated, const std::vector<ExposurePulse>& pulses, std::uint64_t seed,
                            const RunTimes& times, const std::string& folder, const ClockTruth& clock,
                            ImageCount& count) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) return cannot_write(folder, error.value());
  const ImageRenderer renderer(scene, caster, camera.model);
  std::vector<FrameRecord> frames;
  for (std::size_t i = 0; i < pulses.size(); ++i) {
    const double begin_s = camera.begin_s(pulses[i]);
    const double middle_s = camera.middle_s(pulses[i]);
    char file[32];
    std::snprintf(file, sizeof file, "%06zu.png", i);
    if (const auto written = write_frame(renderer, camera, simulated.motion.T_scene_base(middle_s), middle_s, seed, i,
                                         (fs::path(folder) / file).string());
        !written)
      return written.error();
    FrameRecord frame;
    frame.file = file;
    frame.stamp_ns = times.sampling_ns + ns_of_seconds(middle_s);
    if (camera.triggered) frame.trigger = static_cast<std::int64_t>(i);
    frame.exposure_us = camera.chip.exposure_us;
    // The camera stamps the beginning of the exposure.
    const std::int64_t since_start = times.sampling_ns + ns_of_seconds(begin_s) - times.start_ns;
    frame.device_stamp = clock.offset_ns + times.start_ns + since_start +
                         std::llround(static_cast<double>(since_start) * clock.drift_ppm * 1e-6);
    frame.stop = pulses[i].stop;
    frames.push_back(frame);
    if (const auto go_on = count.add(); !go_on) return go_on.error();
  }
  return write_frames((fs::path(folder) / "frames.csv").string(), frames);
}

}  // namespace

Expected<void> check_cameras(const Rig& rig) {
  const auto cameras = simulated_cameras(rig, std::vector<SE3>(rig.sensors.size()));
  if (!cameras) return cameras.error();
  return {};
}

Expected<std::uint64_t> write_session_images(const Scene& scene, const Rig& rig, const SimulatedRig& simulated,
                                             std::uint64_t seed, const RunTimes& times, int per_stop,
                                             const std::string& session, const RunContext& context,
                                             GroundTruth& truth) {
  const auto cameras = simulated_cameras(rig, simulated.T_base_sensor);
  if (!cameras) return cameras.error();
  if (cameras->empty() || per_stop == 0) return std::uint64_t{0};
  const bool triggered =
      std::any_of(cameras->begin(), cameras->end(), [](const SimulatedCamera& camera) { return camera.triggered; });
  const std::vector<ExposurePulse> pulses = plan_exposures(*cameras, simulated.motion, per_stop);
  const RayCaster caster(scene);
  ImageCount count(cameras->size() * pulses.size(), context);
  for (const SimulatedCamera& camera : *cameras) {
    // Like the LiDARs' clocks: time since the device was switched on.
    ClockTruth clock = camera_clock(seed, camera.sensor);
    clock.offset_ns -= times.start_ns;
    truth.clocks[camera.name] = clock;
    if (const auto written = write_camera(scene, caster, camera, simulated, pulses, seed, times,
                                          (fs::path(session) / "images" / camera.name).string(), clock, count);
        !written)
      return written.error();
  }
  if (triggered) {
    std::vector<TriggerPulse> stamps;
    for (const ExposurePulse& pulse : pulses)
      stamps.push_back({static_cast<std::int64_t>(stamps.size()), times.sampling_ns + ns_of_seconds(pulse.time_s)});
    if (const auto written = write_trigger((fs::path(session) / "trigger.csv").string(), stamps); !written)
      return written.error();
  }
  return count.done();
}

Expected<std::uint64_t> write_patch_images(const Scene& scene, const Rig& rig, const SimulatedRig& simulated,
                                           std::uint64_t seed, const PatchFolderWriter& folder,
                                           const RunContext& context) {
  const auto cameras = simulated_cameras(rig, simulated.T_base_sensor);
  if (!cameras) return cameras.error();
  const std::vector<PatchTime> times = patch_times(simulated.motion);
  const RayCaster caster(scene);
  ImageCount count(cameras->size() * times.size(), context);
  for (const SimulatedCamera& camera : *cameras) {
    const ImageRenderer renderer(scene, caster, camera.model);
    for (std::size_t stop = 0; stop < times.size(); ++stop) {
      const auto path = folder.image_path(camera.sensor, static_cast<int>(stop));
      if (!path) return path.error();
      const double time_s = times[stop].middle_s();
      if (const auto written =
              write_frame(renderer, camera, simulated.motion.T_scene_base_unswung(time_s), time_s, seed, stop, *path);
          !written)
        return written.error();
      if (const auto go_on = count.add(); !go_on) return go_on.error();
    }
  }
  return count.done();
}

}  // namespace rigcal::sim
