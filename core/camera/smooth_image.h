#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/edges/image_edges.h"

namespace rigcal {

/// A grey value and how it changes per pixel of the full image.
struct GreySample {
  float value = 0.0F;
  Eigen::Vector2f slope = Eigen::Vector2f::Zero();
};

/// What becomes of a grey value: `most` times its share of the way from `dark` to `bright`, and nothing beyond these.
struct GreyScale {
  float dark = 0.0F;
  float bright = 255.0F;  ///< Above `dark`.
  float most = 255.0F;
};

/// An image made smaller by halves, each pixel the mean of four, as often as said.
[[nodiscard]] GreyImage halved(const GreyImage& image, int times);

/// An image to be looked up between its pixels: made smaller by halves, then read through a cubic B-spline, which
/// blurs by about 0.6 * 2^halvings pixels and is smooth to the second derivative.
class SmoothImage {
 public:
  /// `scale` comes after the halving. Of `halvings` the image has been made smaller by `done` already.
  SmoothImage(const GreyImage& image, int halvings, const GreyScale& scale = {}, int done = 0);

  /// At a pixel of the full image; beyond its borders the image goes on as it ends.
  [[nodiscard]] float value(const Eigen::Vector2d& pixel) const;
  [[nodiscard]] GreySample at(const Eigen::Vector2d& pixel) const;

 private:
  struct Place {
    std::size_t corner = 0;  ///< Of the 4 x 4 values.
    float fx = 0.0F;         ///< Fractions beyond the second of them.
    float fy = 0.0F;
  };
  [[nodiscard]] Place place(const Eigen::Vector2d& pixel) const;

  int width_ = 0;
  int height_ = 0;
  double per_pixel_ = 1.0;  ///< Small pixels a pixel.
  std::size_t stride_ = 0;  ///< Of the values, which have two more on every side.
  std::vector<float> values_;
};

}  // namespace rigcal
