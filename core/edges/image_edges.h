#pragma once

#include <Eigen/Core>
#include <vector>

namespace rigcal {

/// Grey values, 0 .. 255 whatever the depth of the camera was, rows from the top.
struct GreyImage {
  int width = 0;
  int height = 0;
  std::vector<float> values;

  [[nodiscard]] float at(int x, int y) const {
    return values[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)];
  }
};

/// A place where the grey value steps, in the image as it came (not undistorted).
struct ImageEdge {
  Eigen::Vector2f position;  ///< Pixels; (0, 0) is the centre of the top left one.
  Eigen::Vector2f normal;    ///< Unit, towards the brighter side.
  int chain = 0;             ///< Number of the connected edge that it is part of.
};

/// Edges of an image by the maxima of the gradient across themselves (Canny 1986), to a fraction of a pixel. The noise
/// is estimated from the image itself. In the order of the chains, along each; images of less than 16 pixels a side
/// have none.
[[nodiscard]] std::vector<ImageEdge> find_image_edges(const GreyImage& image);

/// A copy blurred by a Gaussian of `sigma_px`; the borders go on as they end.
[[nodiscard]] GreyImage blurred(const GreyImage& image, double sigma_px);

}  // namespace rigcal
