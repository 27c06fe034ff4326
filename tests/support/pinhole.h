#pragma once

#include "core/rig/rig.h"

namespace rigcal {

/// A camera without distortion whose axis goes through the middle of its image.
inline CameraIntrinsics pinhole(int width, int height, double focal_px) {
  return {DistortionModel::radtan,  width, height, focal_px, focal_px, 0.5 * (width - 1), 0.5 * (height - 1),
          {0.0, 0.0, 0.0, 0.0, 0.0}};
}

}  // namespace rigcal
