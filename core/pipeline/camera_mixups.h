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

/// Of a camera that hung, or whose images were delivered late: the largest group of stops that have one and the same
/// image, their places in the marks in order; empty where every stop has its own. Noise makes no two images the same.
[[nodiscard]] std::vector<std::size_t> repeated_images(const ImageMarks& marks);

/// Tells of cameras that have one image in most of their stops, of cameras whose images are the same in most of the
/// stops that both have, and of pairs that stand where the rig file has each other; none of them is better than `weak`,
/// and that is the first of its reasons. `marks`: one for each of the cameras; `options`: how far a guess may be off.
void tell_mixed_up(std::span<const ImageMarks> marks, const CameraCalibrationOptions& options,
                   std::vector<SensorResult>& cameras);

}  // namespace rigcal
