#include "core/camera/working_size.h"

#include <algorithm>
#include <cmath>

namespace rigcal {
namespace {

constexpr double most_pixels = 2.5e6;
constexpr double least_focal_length = 800.0;  // 0.07 degrees a pixel

}  // namespace

int halvings_of(const CameraIntrinsics& intrinsics) {
  int times = 0;
  double pixels = static_cast<double>(intrinsics.width) * intrinsics.height;
  double focal_length = std::min(intrinsics.fx, intrinsics.fy);
  while (pixels > most_pixels && 0.5 * focal_length >= least_focal_length) {
    pixels *= 0.25;
    focal_length *= 0.5;
    ++times;
  }
  return times;
}

CameraIntrinsics halved(CameraIntrinsics intrinsics, int times) {
  for (int k = 0; k < times; ++k) {
    intrinsics.width /= 2;
    intrinsics.height /= 2;
    intrinsics.fx *= 0.5;
    intrinsics.fy *= 0.5;
    // Pixels are counted by their centres: the first of the half lies between the first two.
    intrinsics.cx = 0.5 * (intrinsics.cx - 0.5);
    intrinsics.cy = 0.5 * (intrinsics.cy - 0.5);
  }
  return intrinsics;
}

CameraEstimate at_full_size(CameraEstimate estimate, const CameraIntrinsics& given, int halvings) {
  const double scale = std::ldexp(1.0, halvings);
  CameraIntrinsics& found = estimate.intrinsics;
  found.width = given.width;
  found.height = given.height;
  found.fx *= scale;
  found.fy *= scale;
  found.cx = scale * found.cx + 0.5 * (scale - 1.0);
  found.cy = scale * found.cy + 0.5 * (scale - 1.0);
  estimate.residual_px *= scale;
  estimate.hold_out_px *= scale;
  estimate.hold_out_start_px *= scale;
  for (ScalarEstimate* px : {&estimate.radial_trend, &estimate.cx_change_px, &estimate.cy_change_px}) {
    px->value *= scale;
    px->sigma *= scale;
  }
  return estimate;
}

}  // namespace rigcal
