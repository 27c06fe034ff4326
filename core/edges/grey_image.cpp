#include "core/edges/grey_image.h"

#include <algorithm>
#include <array>
#include <utility>

#include "core/base/median.h"
#include "core/base/wide.h"
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

// One, two and one parts of each place of three rows.
RIGCAL_WIDE void mix(const float* before, const float* here, const float* after, float* __restrict out,
                     std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) out[i] = 0.25F * before[i] + 0.5F * here[i] + 0.25F * after[i];
}

RIGCAL_WIDE void scaled_bytes(const std::uint8_t* bytes, float scale, float* __restrict out, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) out[i] = scale * static_cast<float>(bytes[i]);
}

// What lies beyond the border is mirrored, so that the colours of the mosaic keep their order.
GreyImage without_mosaic(GreyImage raw) {
  const auto width = static_cast<std::size_t>(raw.width);
  const auto height = static_cast<std::size_t>(raw.height);
  GreyImage across = raw;
  for (std::size_t y = 0; y < height && width > 1; ++y) {
    const float* from = raw.values.data() + y * width;
    float* to = across.values.data() + y * width;
    mix(from, from + 1, from + 2, to + 1, width - 2);
    mix(from + 1, from, from + 1, to, 1);
    mix(from + width - 2, from + width - 1, from + width - 2, to + width - 1, 1);
  }
  for (std::size_t y = 0; y < height; ++y) {
    const std::size_t before = height < 2 ? y : (y == 0 ? 1 : y - 1);
    const std::size_t after = height < 2 ? y : (y == height - 1 ? height - 2 : y + 1);
    const float* from = across.values.data();
    mix(from + before * width, from + y * width, from + after * width, raw.values.data() + y * width, width);
  }
  return raw;
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
  // Formats of 16 bits are what values of 10 to 14 are carried in, too: then those tell.
  const bool is_told = format && format->bits > 8 && format->bits < 16;
  if (is_told) return largest >> format->bits == 0 ? format->bits : 16;
  return *std::find_if(depths.begin(), depths.end(), [&](int bits) { return largest >> bits == 0; });
}

GreyImage to_grey(const Image& image, int bits) {
  GreyImage grey{image.width, image.height, {}};
  grey.values.resize(static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height));
  const float scale = 255.0F / static_cast<float>((1 << bits) - 1);
  if (image.channels == 1 && image.bits == 8) {
    scaled_bytes(image.bytes.data(), scale, grey.values.data(), grey.values.size());
    return is_mosaic(image) ? without_mosaic(std::move(grey)) : grey;
  }
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
  return is_mosaic(image) ? without_mosaic(std::move(grey)) : grey;
}

GreyImage halved(GreyImage grey, int times) {
  for (int k = 0; k < times; ++k) {
    GreyImage half{grey.width / 2, grey.height / 2, {}};
    half.values.reserve(static_cast<std::size_t>(half.width) * static_cast<std::size_t>(half.height));
    for (int y = 0; y < half.height; ++y) {
      for (int x = 0; x < half.width; ++x) {
        half.values.push_back(0.25F * (grey.at(2 * x, 2 * y) + grey.at(2 * x + 1, 2 * y) + grey.at(2 * x, 2 * y + 1) +
                                       grey.at(2 * x + 1, 2 * y + 1)));
      }
    }
    grey = std::move(half);
  }
  return grey;
}

float grey_spread(const GreyImage& grey) {
  // Shares of so many pixels are those of all, and of all kinds of columns and rows as the step is odd.
  constexpr std::size_t looked_at = 50'000;
  if (grey.values.empty()) return 0.0F;
  const std::size_t step = std::max<std::size_t>(1, grey.values.size() / looked_at) | 1U;
  std::vector<float> values;
  for (std::size_t i = 0; i < grey.values.size(); i += step) values.push_back(grey.values[i]);
  const auto at = [&](std::size_t percent) { return of_rank(values, (values.size() - 1) * percent / 100); };
  const float low = at(1);
  return at(99) - low;
}

}  // namespace rigcal
