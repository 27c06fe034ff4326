#pragma once

#include <memory>

#include "drivers/camera/aravis/aravis_backend.h"

namespace rigcal::camera {

[[nodiscard]] std::unique_ptr<Camera> make_aravis_camera(const AravisOptions& options);

}  // namespace rigcal::camera
