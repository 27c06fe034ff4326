#pragma once

#include <memory>
#include <string>

#include "drivers/camera/camera.h"
#include "simdata/gige/camera_server.h"
#include "simdata/gige/test_pattern.h"

namespace rigcal::camera {

/// A GigE Vision device of ours with a test pattern, on an address of the loopback network of its own.
inline sim::ServedCamera virtual_camera(std::uint8_t last, const std::string& serial) {
  sim::ServedCamera camera;
  gige::DeviceIdentity& identity = camera.device.identity;
  identity.mac = {0x34, 0xBD, 0x20, 0, 8, last};
  identity.ip = {127, 0, 8, last};
  identity.mask = {255, 0, 0, 0};
  identity.manufacturer = "Hikrobot";
  identity.model = "MV-CA013-21UC";
  identity.device_version = "V1.0";
  identity.serial = serial;
  camera.device.pixel_formats = {"BayerRG8", "BayerRG12", "Mono8"};
  camera.device.exposure_us = 1000.0;
  camera.source = std::make_shared<sim::TestPattern>();
  return camera;
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
