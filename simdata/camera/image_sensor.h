#pragma once

#include <cstdint>

#include "core/base/error.h"
#include "core/records/image.h"
#include "core/records/pixel_format.h"
#include "core/rig/rig.h"
#include "simdata/camera/image_renderer.h"

namespace rigcal::sim {

/// A camera's sensor: what it makes of the light, in electrons and grey levels.
struct ImageSensor {
  PixelFormat format;
  std::string format_name;  ///< As the rig file says it.
  double exposure_us = 5000.0;
  double gain_db = 0.0;
  double full_well = 10'000.0;  ///< Electrons that make the largest value at 0 dB.
  double read_noise = 8.0;      ///< Electrons, 1 sigma.
  double black_level = 0.01;    ///< Of the largest value: where no light is.
  double blur_px = 0.6;         ///< Sigma of the lens' blur.

  /// As the rig file sets the camera. Errors: a pixel format that is packed or not known.
  [[nodiscard]] static Expected<ImageSensor> of(const Sensor& sensor);
};

/// Exposes a frame: blur, colour filters (one of them a pixel where the format is a Bayer one), shot noise, read noise,
/// gain, clipping and rounding. `seed` and `frame` choose the noise; the same bits for any number of threads.
[[nodiscard]] Image expose(const LightField& light, const ImageSensor& sensor, std::uint64_t seed, std::uint64_t frame);

}  // namespace rigcal::sim
