#include "core/report/rpy.h"

#include <cmath>

namespace rigcal {

Vector3d rpy_from_rotation(const Matrix3d& R) {
  // Yaw first, and the rest from what is left after turning back by it: roll then makes up for whatever yaw is where
  // the two cannot be told apart, which independent formulas for both would not.
  const double yaw = std::atan2(R(1, 0), R(0, 0));
  const double s = std::sin(yaw);
  const double c = std::cos(yaw);
  const double pitch = std::atan2(-R(2, 0), c * R(0, 0) + s * R(1, 0));
  const double roll = std::atan2(s * R(0, 2) - c * R(1, 2), c * R(1, 1) - s * R(0, 1));
  return {roll, pitch, yaw};
}

}  // namespace rigcal
