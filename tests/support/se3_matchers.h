#pragma once

#include <gmock/gmock.h>

#include "core/geometry/se3.h"

namespace rigcal {

inline SE3 pose_deg(double rx_deg, double ry_deg, double rz_deg, double tx, double ty, double tz) {
  return {exp_so3(Vector3d(to_rad(rx_deg), to_rad(ry_deg), to_rad(rz_deg))), Vector3d(tx, ty, tz)};
}

/// Matches an SE3 within a rotation in degrees and a translation in millimetres of `expected`, and says how far it is.
MATCHER_P3(SE3Near, expected, rotation_deg, translation_mm, "") {
  const double deg = to_deg(rotation_distance(arg.R, expected.R));
  const double mm = 1e3 * (arg.t - expected.t).norm();
  *result_listener << "off by " << deg << " deg and " << mm << " mm";
  return deg <= rotation_deg && mm <= translation_mm;
}

}  // namespace rigcal
