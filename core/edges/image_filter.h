#pragma once

#include <vector>

#include "core/edges/image_edges.h"

namespace rigcal {

/// A Gaussian's values, an odd number of them, with the sum one.
[[nodiscard]] std::vector<float> gaussian(double sigma_px);

/// Correlates all rows, then all columns of an image with a kernel of odd length; the borders go on as they end.
[[nodiscard]] GreyImage correlated(const GreyImage& image, const std::vector<float>& kernel);

/// How an image changes, in grey values a pixel, after it was blurred by a Gaussian.
struct ImageGradient {
  GreyImage x;
  GreyImage y;
  GreyImage length;
};
[[nodiscard]] ImageGradient gradient_of(const GreyImage& image, double blur_px);

}  // namespace rigcal
