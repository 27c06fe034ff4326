#pragma once

#include <string>

#include "core/quality/result.h"

namespace rigcal {

/// The verdict in one sentence, the same on the page and in the terminal: "All 4 sensors are good." or "2 of 4 sensors
/// are good: camera_left is weak, mid40_right failed."
[[nodiscard]] std::string summary_sentence(const CalibrationResult& result);

/// How well one sensor is known, in a clause without its reasons: "known to 0.6 mm and 0.003 degrees (95 %)".
[[nodiscard]] std::string bounds_text(const CalibrationResult& result, const SensorResult& sensor);

/// By which a reader can try which way a transform goes: "1 m ahead of mid100_left, [1, 0, 0], is [0.866, 0.600,
/// -0.050] in avia". The same point is to the right of a camera, whose frame is the optical one.
[[nodiscard]] std::string worked_point_text(const std::string& sensor, bool is_camera, const std::string& base,
                                            const SE3& T_base_sensor);

}  // namespace rigcal
