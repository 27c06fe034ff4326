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
  // To the second pixel of a pair; an image that is one pixel wide or high has none.
  const int right = image.width > 1 ? 1 : 0;
  const std::size_t below = image.height > 1 ? static_cast<std::size_t>(image.width) : 0;
  for (int y = 0; y < half.height; ++y) {
    const float* in = image.values.data() + 2 * static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width);
    float* out = half.values.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(half.width);
    for (int x = 0; x < half.width; ++x, in += 2)
      out[x] = 0.25F * (in[0] + in[right] + in[below] + in[below + static_cast<std::size_t>(right)]);
  }
  return half;
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

SmoothImage::SmoothImage(const GreyImage& image, int halvings, const GreyScale& scale, int done)
    : per_pixel_(std::pow(0.5, halvings)) {
  GreyImage small;
  if (halvings > done) small = halved(image, halvings - done);
  const GreyImage* from = halvings > done ? &small : &image;
  width_ = from->width;
  height_ = from->height;
  const auto width = static_cast<std::size_t>(width_);
  stride_ = width + 2 * border;
  values_.resize(stride_ * static_cast<std::size_t>(height_ + 2 * border));
  const float per_grey = scale.most / (scale.bright - scale.dark);
  for (int y = -border; y < height_ + border; ++y) {
    const float* in = from->values.data() + static_cast<std::size_t>(std::clamp(y, 0, height_ - 1)) * width;
    float* out = values_.data() + static_cast<std::size_t>(y + border) * stride_ + border;
    for (std::size_t x = 0; x < width; ++x) out[x] = std::clamp(per_grey * (in[x] - scale.dark), 0.0F, scale.most);
    std::fill_n(out - border, border, out[0]);
    std::fill_n(out + width, border, out[width - 1]);
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
