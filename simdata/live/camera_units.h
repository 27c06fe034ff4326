#pragma once

#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/rig/rig.h"
#include "simdata/gige/virtual_camera.h"

/// The cameras of a rig file as GigE Vision devices.
namespace rigcal::sim {

/// Whether a camera of a rig is one that `simulate --live` serves: its driver is aravis and it has intrinsics.
[[nodiscard]] bool is_served(const Sensor& sensor);

/// By sensor of the rig; zero for those that are not served. A camera whose `device` is an address lives there, the
/// others from .31 on in the host's network, where nothing else of the rig lives. Errors: two with one address.
[[nodiscard]] Expected<std::vector<gige::Ipv4>> camera_addresses(const Rig& rig);

/// Who the camera says it is: `device` of the rig file, read as maker-model-serial.
[[nodiscard]] gige::DeviceIdentity camera_identity(const Sensor& sensor, const gige::Ipv4& ip);

/// The pixel formats that it offers: the rig file's first, the same colours and grey in 8, 10 and 12 bits. Errors: the
/// rig file's has no number on the wire.
[[nodiscard]] Expected<std::vector<std::string>> camera_formats(const Sensor& sensor);

}  // namespace rigcal::sim
