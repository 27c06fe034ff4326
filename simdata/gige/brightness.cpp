#include "simdata/gige/brightness.h"

#include <cmath>

#include "core/records/pixel_format.h"
#include "drivers/gige_codec/pixel_code.h"

namespace rigcal::sim {

double mean_brightness(const std::vector<std::uint8_t>& image, std::uint32_t pixel_format) {
  const PixelFormat format = parse_pixel_format(gige::pixel_name(pixel_format)).value_or(PixelFormat{});
  const auto bytes = static_cast<std::size_t>(format.stored_bits() / 8);
  constexpr std::size_t step = 997;  // Every so many values are looked at.
  double sum = 0.0;
  std::size_t count = 0;
  for (std::size_t i = 0; i + bytes <= image.size(); i += step * bytes, ++count)
    sum += bytes == 1 ? image[i] : image[i] | image[i + 1] << 8U;
  return count == 0 ? 0.0 : sum / static_cast<double>(count) / (std::pow(2.0, format.bits) - 1.0);
}

}  // namespace rigcal::sim
