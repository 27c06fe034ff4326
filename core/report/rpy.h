#pragma once

#include "core/geometry/se3.h"

namespace rigcal {

/// [roll, pitch, yaw] in rad with R = Rz(yaw) Ry(pitch) Rx(roll), the order of URDF and ROS; pitch in [-pi/2, pi/2].
/// Where pitch is +-pi/2 only yaw -+ roll is fixed: any of the answers, which give R back to rounding like all others.
[[nodiscard]] Vector3d rpy_from_rotation(const Matrix3d& R);

}  // namespace rigcal
