#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "simdata/gige/camera_server.h"
#include "simdata/gige/test_pattern.h"

namespace rigcal::sim {

/// A GigE Vision device of ours with a test pattern, at 127.0.NETWORK.LAST.
[[nodiscard]] inline ServedCamera served_camera_at(std::uint8_t network, std::uint8_t last, const std::string& serial) {
  ServedCamera camera;
  gige::DeviceIdentity& identity = camera.device.identity;
  identity.mac = {0x34, 0xBD, 0x20, 0, network, last};
  identity.ip = {127, 0, network, last};
  identity.mask = {255, 0, 0, 0};
  identity.manufacturer = "Hikrobot";
  identity.model = "MV-CA013-21UC";
  identity.device_version = "V1.0";
  identity.serial = serial;
  camera.device.pixel_formats = {"BayerRG8", "BayerRG12", "Mono8"};
  camera.device.exposure_us = 1000.0;
  camera.source = std::make_shared<TestPattern>();
  return camera;
}

}  // namespace rigcal::sim
