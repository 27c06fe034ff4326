#pragma once

#include "core/edges/image_edges.h"

namespace cv {
class Mat;
}

namespace rigcal {

/// Grey levels between the dark and the bright squares of a board, at least.
constexpr double least_board_contrast = 12.0;

/// Grey values as OpenCV's detectors want them, CV_8UC1. A dark image, in which lamps alone are bright, is made
/// brighter: so that all but a fiftieth of it uses four fifths of the values. For sources of this room alone.
[[nodiscard]] cv::Mat bytes_of(const GreyImage& grey);

}  // namespace rigcal
