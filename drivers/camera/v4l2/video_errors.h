#pragma once

#include <cerrno>
#include <string>
#include <system_error>

#include "core/base/error.h"
#include "drivers/camera/camera.h"

namespace rigcal::camera {

/// What a call of the system that gave `code` (an errno below zero) means for a user.
[[nodiscard]] inline Error video_error(const std::string& what, const std::string& where, int code) {
  const std::string why = what + ": " + std::generic_category().message(-code);
  switch (-code) {
    case EBUSY:
      return system_error(what + ": another program uses it", where,
                          "end that program; 'fuser -v " + where + "' names it");
    case EACCES:
    case EPERM:
      return system_error("this user may not open the camera", where,
                          "'sudo usermod -aG video $USER', and log in again");
    case ENODEV:
    case ENOENT:
    case ENXIO:
      return system_error(camera_is_gone, where, "plug it in");
    case ENOSPC:
      return system_error(what + ": the USB has not enough room for it", where,
                          "plug it into another USB controller, or choose smaller images or a lower rate");
    case ENOMEM:
      return system_error(what + ": there is not enough memory", where, "ask for fewer buffers");
    default:
      return system_error(why, where, "unplug the camera and plug it in again");
  }
}

}  // namespace rigcal::camera
