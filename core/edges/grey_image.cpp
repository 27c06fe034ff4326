#include "core/edges/grey_image.h"

#include <algorithm>
#include <array>

#include "core/records/pixel_format.h"

namespace rigcal {
namespace {

int largest_value(const Image& image) {
  int largest = 0;
  const std::size_t values = image.bytes.size() / static_cast<std::size_t>(image.bits / 8);
  for (std::size_t i = 0; i < values; ++i) {
    const int value = image.bits == 8 ? image.bytes[i] : image.bytes[2 * i] | image.bytes[2 * i + 1] << 8;
    largest = std::max(largest, value);
  }
  return largest;
}

// The places before and after i, mirrored at the ends so that the colours of the mosaic keep their order.
std::array<int, 2> neighbours(int i, int size) {
  if (size < 2) return {i, i};
  return {i == 0 ? 1 : i - 1, i == size - 1 ? size - 2 : i + 1};
}

GreyImage without_mosaic(const GreyImage& raw) {
  GreyImage rows = raw;
  for (int y = 0; y < raw.height; ++y) {
    const std::size_t row = static_cast<std::size_t>(y) * static_cast<std::size_t>(raw.width);
    for (int x = 0; x < raw.width; ++x) {
      const auto [before, after] = neighbours(x, raw.width);
      rows.values[row + static_cast<std::size_t>(x)] =
          0.25F * raw.at(before, y) + 0.5F * raw.at(x, y) + 0.25F * raw.at(after, y);
    }
  }
  GreyImage grey = rows;
  for (int y = 0; y < raw.height; ++y) {
    const auto [before, after] = neighbours(y, raw.height);
    const std::size_t row = static_cast<std::size_t>(y) * static_cast<std::size_t>(raw.width);
    for (int x = 0; x < raw.width; ++x) {
      grey.values[row + static_cast<std::size_t>(x)] =
          0.25F * rows.at(x, before) + 0.5F * rows.at(x, y) + 0.25F * rows.at(x, after);
    }
  }
  return grey;
}

}  // namespace

bool is_mosaic(const Image& image) {
  const auto format = parse_pixel_format(image.pixel_format);
  if (!format || image.channels != 1) return false;
  return format->layout != PixelLayout::mono && format->channels() == 1;
}

int value_bits(const Image& image) {
  if (image.bits == 8) return 8;
  constexpr std::array<int, 5> depths{8, 10, 12, 14, 16};
  const int largest = largest_value(image);
  const auto format = parse_pixel_format(image.pixel_format);
  if (format && format->bits > 8 && largest >> format->bits == 0) return format->bits;
  if (format && format->bits > 8) return 16;
  return *std::find_if(depths.begin(), depths.end(), [&](int bits) { return largest >> bits == 0; });
}

GreyImage to_grey(const Image& image, int bits) {
  GreyImage grey{image.width, image.height, {}};
  grey.values.resize(static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height));
  const float scale = 255.0F / static_cast<float>((1 << bits) - 1);
  auto out = grey.values.begin();
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x, ++out) {
      if (image.channels == 1) {
        *out = scale * static_cast<float>(image.at(x, y));
      } else {
        *out =
            scale * (0.299F * static_cast<float>(image.at(x, y, 0)) + 0.587F * static_cast<float>(image.at(x, y, 1)) +
                     0.114F * static_cast<float>(image.at(x, y, 2)));
      }
    }
  }
  return is_mosaic(image) ? without_mosaic(grey) : grey;
}

float grey_spread(const GreyImage& grey) {
  // Shares of so many pixels are those of all, and of all kinds of columns and rows as the step is odd.
  constexpr std::size_t looked_at = 50'000;
  if (grey.values.empty()) return 0.0F;
  const std::size_t step = std::max<std::size_t>(1, grey.values.size() / looked_at) | 1U;
  std::vector<float> values;
  for (std::size_t i = 0; i < grey.values.size(); i += step) values.push_back(grey.values[i]);
  const auto at = [&](std::size_t percent) {
    const auto place = values.begin() + static_cast<std::ptrdiff_t>((values.size() - 1) * percent / 100);
    std::nth_element(values.begin(), place, values.end());
    return *place;
  };
  const float low = at(1);
  return at(99) - low;
}

}  // namespace rigcal
