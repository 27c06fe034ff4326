#pragma once

#include <string>
#include <vector>

#include "core/pipeline/camera_stage.h"
#include "core/records/records.h"
#include "core/rig/rig.h"

namespace rigcal {

/// The cameras of a rig whose images are in a bag, by the topics of the rig file. The bag is read again for each, when
/// its turn has come: only then is it known which of perhaps thousands of images were taken in a stop.
[[nodiscard]] std::vector<CameraRecording> bag_camera_recordings(const Rig& rig, const std::vector<Stop>& stops,
                                                                 const std::string& path);

}  // namespace rigcal
