#include "core/edges/image_filter.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/wide.h"

namespace rigcal {
namespace {

// Of a kernel that are taken at once: those of a blur of 1.25 pixels.
constexpr std::size_t taps = 11;

// Adds to each value of a row those of some others, or of its own neighbours, by their weights.
RIGCAL_WIDE void add_taps(const std::array<const float*, taps>& from, const std::array<float, taps>& weights,
                          float* __restrict out, std::size_t width) {
  const std::array<const float*, taps> rows = from;
  const std::array<float, taps> k = weights;
  for (std::size_t x = 0; x < width; ++x) {
    float sum = out[x];
    for (std::size_t i = 0; i < taps; ++i) sum += k[i] * rows[i][x];
    out[x] = sum;
  }
}

RIGCAL_WIDE void lengths(const float* x, const float* y, float* __restrict out, std::size_t width) {
  for (std::size_t i = 0; i < width; ++i) out[i] = std::sqrt(x[i] * x[i] + y[i] * y[i]);
}

// The sum of a kernel's length of rows by its weights; `row(i)` is that of the kernel's value i.
template <class Row>
void weigh(const std::vector<float>& kernel, const Row& row, float* out, std::size_t width) {
  std::fill_n(out, width, 0.0F);
  for (std::size_t first = 0; first < kernel.size(); first += taps) {
    std::array<const float*, taps> rows;
    std::array<float, taps> weights{};
    for (std::size_t i = 0; i < taps; ++i) {
      const std::size_t at = std::min(first + i, kernel.size() - 1);
      rows[i] = row(at);
      if (first + i < kernel.size()) weights[i] = kernel[at];
    }
    add_taps(rows, weights, out, width);
  }
}

// Rows of an image, correlated with kernels of one length.
class RowFilter {
 public:
  RowFilter(const GreyImage& image, std::size_t length)
      : image_(image), width_(static_cast<std::size_t>(image.width)), radius_(length / 2) {
    line_.resize(width_ + 2 * radius_);
  }

  // Across the rows around y, then along the row.
  void run(int y, const std::vector<float>& across, const std::vector<float>& along, float* out) {
    const auto row = [&](std::size_t i) {
      const int at = std::clamp(y + static_cast<int>(i) - static_cast<int>(radius_), 0, image_.height - 1);
      return image_.values.data() + static_cast<std::size_t>(at) * width_;
    };
    weigh(across, row, line_.data() + radius_, width_);
    std::fill_n(line_.data(), radius_, line_[radius_]);
    std::fill_n(line_.data() + radius_ + width_, radius_, line_[radius_ + width_ - 1]);
    weigh(
        along, [&](std::size_t i) { return line_.data() + i; }, out, width_);
  }

 private:
  const GreyImage& image_;
  std::size_t width_;
  std::size_t radius_;
  std::vector<float> line_;
};

// The derivative of a Gaussian, such that a slope of one grey value a pixel gives one.
std::vector<float> derivative_of(std::vector<float> kernel) {
  const int radius = static_cast<int>(kernel.size() / 2);
  double moment = 0.0;
  for (int i = -radius; i <= radius; ++i) {
    float& k = kernel[static_cast<std::size_t>(i + radius)];
    k *= static_cast<float>(i);
    moment += static_cast<double>(k) * i;
  }
  for (float& k : kernel) k /= static_cast<float>(moment);
  return kernel;
}

GreyImage empty_like(const GreyImage& image) {
  return {image.width, image.height, std::vector<float>(image.values.size())};
}

}  // namespace

std::vector<float> gaussian(double sigma_px) {
  const int radius = std::max(1, static_cast<int>(std::ceil(4.0 * sigma_px)));
  std::vector<float> kernel;
  double sum = 0.0;
  for (int i = -radius; i <= radius; ++i) sum += std::exp(-0.5 * i * i / (sigma_px * sigma_px));
  for (int i = -radius; i <= radius; ++i) {
    kernel.push_back(static_cast<float>(std::exp(-0.5 * i * i / (sigma_px * sigma_px)) / sum));
  }
  return kernel;
}

GreyImage correlated(const GreyImage& image, const std::vector<float>& kernel) {
  GreyImage out = empty_like(image);
  RowFilter filter(image, kernel.size());
  for (int y = 0; y < image.height; ++y) {
    filter.run(y, kernel, kernel,
               out.values.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(out.width));
  }
  return out;
}

ImageGradient gradient_of(const GreyImage& image, double blur_px) {
  const std::vector<float> smooth = gaussian(blur_px);
  const std::vector<float> slope = derivative_of(smooth);
  ImageGradient out{empty_like(image), empty_like(image), empty_like(image)};
  RowFilter filter(image, smooth.size());
  const auto width = static_cast<std::size_t>(image.width);
  for (int y = 0; y < image.height; ++y) {
    const std::size_t row = static_cast<std::size_t>(y) * width;
    filter.run(y, smooth, slope, out.x.values.data() + row);
    filter.run(y, slope, smooth, out.y.values.data() + row);
    lengths(out.x.values.data() + row, out.y.values.data() + row, out.length.values.data() + row, width);
  }
  return out;
}

}  // namespace rigcal
