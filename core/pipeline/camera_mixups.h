#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "core/camera/camera_calibration.h"
#include "core/quality/result.h"

namespace rigcal {

/// By which a camera's images are known again: the stop of each, and a number that is the same where its grey values
/// are.
using ImageMarks = std::vector<std::pair<int, std::uint64_t>>;
[[nodiscard]] ImageMarks image_marks(const std::vector<CameraView>& views);

/// Tells of cameras whose images are the same in most of the stops that both have, and of pairs that stand where the
/// rig file has each other; neither is better than `weak`, and that is the first of its reasons. `marks`: one for each
/// of the cameras; `options`: how far a guess may be off.
void tell_mixed_up(std::span<const ImageMarks> marks, const CameraCalibrationOptions& options,
                   std::vector<SensorResult>& cameras);

}  // namespace rigcal
