#include "apps/cameras/rig_cameras.h"

#include <cstdlib>
#include <filesystem>

#include "drivers/camera/aravis/aravis_backend.h"
#include "drivers/camera/v4l2/video_backend.h"

namespace rigcal {
namespace {

camera::CameraConfig config_of(const CameraSettings& settings) {
  camera::CameraConfig config;
  config.pixel_format = settings.pixel_format;
  config.exposure_us = settings.exposure_us;
  config.gain = settings.gain;
  config.frame_rate = settings.frame_rate;
  config.packet_bytes = settings.packet_size;
  config.packet_delay_ns = settings.packet_delay;
  config.ptp = settings.ptp.value_or(false);
  config.strobe = settings.strobe.value_or("");
  if (settings.trigger) {
    const TriggerSettings& trigger = *settings.trigger;
    config.trigger = camera::TriggerConfig{trigger.source, trigger.activation == "falling", trigger.delay_us};
  }
  return config;
}

}  // namespace

std::vector<RigCamera> rig_cameras(const Rig& rig) {
  std::vector<RigCamera> cameras;
  for (const Sensor& sensor : rig.sensors) {
    if (!sensor.camera || (sensor.camera->driver != "aravis" && sensor.camera->driver != "v4l2")) continue;
    RigCamera camera{sensor.name, sensor.camera->driver, sensor.camera->device, config_of(*sensor.camera), {}, false,
                     false};
    camera.is_told = camera.config.trigger && camera.config.trigger->source == "Software";
    camera.has_pulses = rig.trigger && rig.trigger->line && camera.config.trigger && !camera.is_told;
    if (const auto& intrinsics = sensor.camera->intrinsics) {
      camera.size = {intrinsics->width, intrinsics->height};
      // Devices of Video4Linux have sizes to choose from; others send what their sensor has.
      if (camera.driver == "v4l2") camera.config.region = camera::Region{0, 0, intrinsics->width, intrinsics->height};
    }
    cameras.push_back(std::move(camera));
  }
  return cameras;
}

CameraDrivers::CameraDrivers(const std::string& settings_folder) {
  camera::AravisOptions aravis;
  aravis.settings_folder = settings_folder;
  backends_.push_back(std::make_unique<camera::AravisBackend>(aravis));
  backends_.push_back(std::make_unique<camera::VideoBackend>());
}

std::unique_ptr<camera::Camera> CameraDrivers::make(const std::string& driver) {
  for (const auto& backend : backends_) {
    if (backend->name() == driver) return backend->make();
  }
  abort_with("no driver of cameras is called " + driver, __FILE__, __LINE__);
}

std::vector<camera::CameraIdentity> CameraDrivers::enumerate() {
  std::vector<camera::CameraIdentity> all;
  for (const auto& backend : backends_) {
    const auto there = backend->enumerate();
    if (there) all.insert(all.end(), there->begin(), there->end());
  }
  return all;
}

Expected<camera::CameraSetup> prepare(camera::Camera& opened, const RigCamera& wanted) {
  const auto of_sensor = [&wanted](const Error& error) {
    return Error{error.kind, error.what, error.where.empty() ? wanted.sensor : wanted.sensor + " (" + error.where + ")",
                 error.mend};
  };
  if (wanted.device.empty()) {
    return system_error("the rig file names no device for this camera", wanted.sensor,
                        "give it a device: rigcal doctor lists those that are there");
  }
  if (const auto done = opened.open(wanted.device); !done) return of_sensor(done.error());
  auto setup = opened.configure(wanted.config);
  if (!setup) return of_sensor(setup.error());
  if (wanted.size && (setup->width != (*wanted.size)[0] || setup->height != (*wanted.size)[1])) {
    setup->notes.push_back("it sends " + std::to_string(setup->width) + " x " + std::to_string(setup->height) +
                           " pixels, and its intrinsics are for " + std::to_string((*wanted.size)[0]) + " x " +
                           std::to_string((*wanted.size)[1]));
  }
  return setup;
}

std::string camera_settings_folder() {
  namespace fs = std::filesystem;
  const char* state = std::getenv("XDG_STATE_HOME");
  if (state != nullptr && state[0] == '/') return (fs::path(state) / "rigcal" / "cameras").string();
  const char* home = std::getenv("HOME");
  if (home == nullptr || home[0] != '/') return {};
  return (fs::path(home) / ".local" / "state" / "rigcal" / "cameras").string();
}

}  // namespace rigcal
