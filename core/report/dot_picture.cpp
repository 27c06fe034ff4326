#include "core/report/dot_picture.h"

#include <algorithm>
#include <cmath>

#include "core/io/png_file.h"

namespace rigcal {
namespace {

constexpr std::array<double, 3> ground{16.0, 20.0, 26.0};
constexpr double least_share = 0.7;  // of its colour that a pixel with one dot gets

}  // namespace

DotPicture::DotPicture(int width, int height)
    : width_(std::max(width, 1)),
      height_(std::max(height, 1)),
      pixels_(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_)) {}

void DotPicture::dot(double x, double y, const std::array<std::uint8_t, 3>& rgb) {
  for (const double dx : {-0.5, 0.5}) {
    for (const double dy : {-0.5, 0.5}) paint(x + dx, y + dy, rgb);
  }
}

void DotPicture::paint(double x, double y, const std::array<std::uint8_t, 3>& rgb) {
  // Not in these bounds is also what is no number.
  if (!(x >= 0.0 && x < width_ && y >= 0.0 && y < height_)) return;
  Pixel& pixel = pixels_[static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x)];
  for (std::size_t c = 0; c < 3; ++c) pixel.sum[c] += rgb[c];
  ++pixel.count;
  ++painted_;
}

std::vector<std::uint8_t> DotPicture::png() const {
  const auto filled = static_cast<double>(
      std::count_if(pixels_.begin(), pixels_.end(), [](const Pixel& pixel) { return pixel.count > 0; }));
  const double usual = std::max(static_cast<double>(painted_) / std::max(filled, 1.0), 1.0);
  std::vector<std::uint8_t> rgb;
  rgb.reserve(3 * pixels_.size());
  for (const Pixel& pixel : pixels_) {
    const double bright = 1.0 - std::exp(-static_cast<double>(pixel.count) / usual);
    const double share = pixel.count == 0 ? 0.0 : least_share + (1.0 - least_share) * bright;
    for (std::size_t c = 0; c < 3; ++c) {
      const double colour = pixel.count == 0 ? 0.0 : static_cast<double>(pixel.sum[c]) / pixel.count;
      rgb.push_back(static_cast<std::uint8_t>(std::lround(ground[c] + share * (colour - ground[c]))));
    }
  }
  PixelView view;
  view.width = static_cast<std::uint32_t>(width_);
  view.height = static_cast<std::uint32_t>(height_);
  view.channels = 3;
  view.step = 3 * static_cast<std::size_t>(width_);
  view.data = rgb;
  const auto bytes = encode_png(view);
  return bytes ? *bytes : std::vector<std::uint8_t>();
}

}  // namespace rigcal
