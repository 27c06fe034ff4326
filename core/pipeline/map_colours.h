#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/camera/camera_scene.h"
#include "core/quality/result.h"
#include "core/records/image.h"
#include "core/rig/camera_model.h"

namespace rigcal {

/// An image kept for the colours of the map: three channels of 8 bits, made smaller so that those of all stops fit into
/// memory.
struct ColourPicture {
  Image rgb;
  int shrink = 1;  ///< Pixels of the camera's image along a side of one of these.
};

/// The colours of an image as the camera gave them, at most about a million pixels: Bayer mosaics become one colour for
/// each two by two pixels, grey stays grey. `bits` as value_bits has it.
[[nodiscard]] ColourPicture colour_picture(const Image& image, int bits);

/// A picture and where it was taken from.
struct ColourView {
  CameraModel model;
  SE3 T_C_G;
  ColourPicture picture;
  std::size_t camera = 0;  ///< Which of the cameras took it, counted from 0.
};

/// A colour for each point of the map: the mean over all cameras that see it, of each the (at most three) views from
/// nearest by, weighted by how well they are exposed there and by how near they are; points that no view sees have
/// their reflectivity as grey. What hides what is told by `samples`, also the nearest of which stand for the points in
/// their cubes of `sample_m`; `blocks` are those of all samples.
[[nodiscard]] std::vector<std::array<std::uint8_t, 3>> colour_map(std::span<const MapPoint> map,
                                                                  std::span<const ColourView> views,
                                                                  std::span<const MapSample> samples,
                                                                  std::span<const SampleBlock> blocks,
                                                                  double sample_m = 0.05);

}  // namespace rigcal
