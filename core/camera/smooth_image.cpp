#include "core/camera/smooth_image.h"

#include <algorithm>
#include <cmath>

namespace rigcal {
namespace {

using Eigen::Array4f;

constexpr int border = 2;

GreyImage half_of(const GreyImage& image) {
  GreyImage half;
  half.width = std::max(1, image.width / 2);
  half.height = std::max(1, image.height / 2);
  half.values.resize(static_cast<std::size_t>(half.width) * static_cast<std::size_t>(half.height));
  for (int y = 0; y < half.height; ++y) {
    const int y0 = std::min(2 * y, image.height - 1);
    const int y1 = std::min(2 * y + 1, image.height - 1);
    float* out = half.values.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(half.width);
    for (int x = 0; x < half.width; ++x) {
      const int x0 = std::min(2 * x, image.width - 1);
      const int x1 = std::min(2 * x + 1, image.width - 1);
      out[x] = 0.25F * (image.at(x0, y0) + image.at(x1, y0) + image.at(x0, y1) + image.at(x1, y1));
    }
  }
  return half;
}

float looked_up(const std::array<float, 256>& scale, float grey) {
  const float g = std::clamp(grey, 0.0F, 255.0F);
  const auto i = std::min<std::size_t>(254, static_cast<std::size_t>(g));
  return scale[i] + (g - static_cast<float>(i)) * (scale[i + 1] - scale[i]);
}

// The cubic B-spline's weights of the four neighbours, and their derivatives.
Array4f weights(float t) {
  const float u = 1.0F - t;
  return Array4f(u * u * u, (3.0F * t - 6.0F) * t * t + 4.0F, (3.0F * u - 6.0F) * u * u + 4.0F, t * t * t) / 6.0F;
}
Array4f weight_slopes(float t) {
  const float u = 1.0F - t;
  return {-0.5F * u * u, (1.5F * t - 2.0F) * t, -(1.5F * u - 2.0F) * u, 0.5F * t * t};
}

}  // namespace

GreyImage halved(const GreyImage& image, int times) {
  GreyImage small = times > 0 ? half_of(image) : image;
  for (int k = 1; k < times; ++k) small = half_of(small);
  return small;
}

SmoothImage::SmoothImage(const GreyImage& image, int halvings, const std::array<float, 256>& scale, int done)
    : per_pixel_(std::pow(0.5, halvings)) {
  GreyImage small;
  if (halvings > done) small = halved(image, halvings - done);
  const GreyImage* from = halvings > done ? &small : &image;
  width_ = from->width;
  height_ = from->height;
  stride_ = static_cast<std::size_t>(width_ + 2 * border);
  values_.resize(stride_ * static_cast<std::size_t>(height_ + 2 * border));
  for (int y = -border; y < height_ + border; ++y) {
    float* out = values_.data() + static_cast<std::size_t>(y + border) * stride_ + border;
    for (int x = -border; x < width_ + border; ++x) {
      out[x] = looked_up(scale, from->at(std::clamp(x, 0, width_ - 1), std::clamp(y, 0, height_ - 1)));
    }
  }
}

SmoothImage::Place SmoothImage::place(const Eigen::Vector2d& pixel) const {
  const double x = std::clamp((pixel.x() + 0.5) * per_pixel_ - 0.5, 0.0, width_ - 1.0);
  const double y = std::clamp((pixel.y() + 0.5) * per_pixel_ - 0.5, 0.0, height_ - 1.0);
  const auto ix = static_cast<std::size_t>(x);
  const auto iy = static_cast<std::size_t>(y);
  return {(iy + border - 1) * stride_ + ix + border - 1, static_cast<float>(x - static_cast<double>(ix)),
          static_cast<float>(y - static_cast<double>(iy))};
}

float SmoothImage::value(const Eigen::Vector2d& pixel) const {
  const Place p = place(pixel);
  const Array4f wy = weights(p.fy);
  Array4f column = Array4f::Zero();
  for (int r = 0; r < 4; ++r) {
    column += wy[r] * Eigen::Map<const Array4f>(values_.data() + p.corner + static_cast<std::size_t>(r) * stride_);
  }
  return (weights(p.fx) * column).sum();
}

GreySample SmoothImage::at(const Eigen::Vector2d& pixel) const {
  const Place p = place(pixel);
  const Array4f wy = weights(p.fy);
  const Array4f sy = weight_slopes(p.fy);
  Array4f column = Array4f::Zero();
  Array4f slope = Array4f::Zero();
  for (int r = 0; r < 4; ++r) {
    const Eigen::Map<const Array4f> row(values_.data() + p.corner + static_cast<std::size_t>(r) * stride_);
    column += wy[r] * row;
    slope += sy[r] * row;
  }
  const Array4f wx = weights(p.fx);
  const auto scale = static_cast<float>(per_pixel_);
  return {(wx * column).sum(), scale * Eigen::Vector2f((weight_slopes(p.fx) * column).sum(), (wx * slope).sum())};
}

}  // namespace rigcal
