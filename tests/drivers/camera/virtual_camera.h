#pragma once

#include <memory>
#include <string>

#include "drivers/camera/camera.h"
#include "simdata/gige/camera_server.h"
#include "tests/support/served_camera.h"

namespace rigcal::camera {

/// A GigE Vision device of ours with a test pattern, on an address of the loopback network of its own.
inline sim::ServedCamera virtual_camera(std::uint8_t last, const std::string& serial) {
  return sim::served_camera_at(8, last, serial);
}

inline std::string id_of(const sim::ServedCamera& camera) {
  const gige::DeviceIdentity& identity = camera.device.identity;
  return identity.manufacturer + "-" + identity.model + "-" + identity.serial;
}

inline std::string address_of(const sim::ServedCamera& camera) { return rigcal::to_string(camera.device.identity.ip); }

/// Small and slow frames, so that a busy machine keeps up.
inline CameraConfig small_config() {
  CameraConfig config;
  config.pixel_format = "BayerRG8";
  config.region = Region{0, 0, 256, 128};
  config.exposure_us = 1000.0;
  config.frame_rate = 30.0;
  return config;
}

}  // namespace rigcal::camera
