#include "simdata/camera/image_sensor.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/parallel.h"
#include "core/base/random.h"

namespace rigcal::sim {
namespace {

constexpr double usual_exposure_us = 5000.0;
constexpr std::size_t rows_at_once = 16;
// Each row draws from a stream of its own, so that rows may be made by any thread.
constexpr std::uint64_t first_stream = std::uint64_t{1} << 40U;
constexpr std::uint64_t rows_a_frame = 1U << 17U;

// How a silicon sensor without correction sees red, green and blue, and all of it behind no filter.
const Color colour_response{0.78F, 1.0F, 0.68F};
const Color grey_response{0.3F, 0.5F, 0.2F};

std::vector<float> blur_weights(double sigma) {
  const int reach = static_cast<int>(std::ceil(4.0 * sigma));
  std::vector<float> weights;
  double sum = 0.0;
  for (int i = -reach; i <= reach; ++i) sum += std::exp(-0.5 * i * i / (sigma * sigma));
  for (int i = -reach; i <= reach; ++i)
    weights.push_back(static_cast<float>(std::exp(-0.5 * i * i / (sigma * sigma)) / sum));
  return weights;
}

// One pass of the blur, along rows (dx = 1) or columns (dy = 1); the border goes on for ever.
LightField blurred(const LightField& light, const std::vector<float>& weights, int dx, int dy) {
  LightField out = light;
  const int reach = static_cast<int>(weights.size() / 2);
  parallel_for(static_cast<std::size_t>(light.height), rows_at_once, [&](std::size_t begin, std::size_t end) {
    for (std::size_t row = begin; row < end; ++row) {
      const int y = static_cast<int>(row);
      for (int x = 0; x < light.width; ++x) {
        Color sum = Color::Zero();
        for (int i = -reach; i <= reach; ++i) {
          sum += weights[static_cast<std::size_t>(i + reach)] *
                 light.at(std::clamp(x + i * dx, 0, light.width - 1), std::clamp(y + i * dy, 0, light.height - 1));
        }
        out.pixels[row * static_cast<std::size_t>(light.width) + static_cast<std::size_t>(x)] = sum;
      }
    }
  });
  return out;
}

// Light behind the filter of one value of a pixel.
float filtered(const Color& light, PixelLayout layout, int x, int y, int channel) {
  switch (layout) {
    case PixelLayout::mono:
      return (grey_response * light).sum();
    case PixelLayout::rgb:
    case PixelLayout::bgr:  // an Image has red first whatever came over the wire
      return colour_response[channel] * light[channel];
    default: {
      const int color = bayer_colour(layout, x, y);
      return colour_response[color] * light[color];
    }
  }
}

}  // namespace

Expected<ImageSensor> ImageSensor::of(const Sensor& sensor) {
  const auto format = parse_pixel_format(sensor.camera->pixel_format);
  if (!format) {
    return input_error("the simulator does not know the pixel format '" + sensor.camera->pixel_format + "'",
                       "sensor '" + sensor.name + "' of the rig",
                       "use Mono, RGB or BayerRG, GR, GB, BG with 8, 10, 12, 14 or 16 bits, for example BayerRG8");
  }
  ImageSensor made;
  made.format = *format;
  made.format_name = sensor.camera->pixel_format;
  made.exposure_us = sensor.camera->exposure_us.value_or(usual_exposure_us);
  made.gain_db = sensor.camera->gain.value_or(0.0);
  return made;
}

Image expose(const LightField& light, const ImageSensor& sensor, std::uint64_t seed, std::uint64_t frame) {
  LightField sharp;
  const LightField* field = &light;
  if (sensor.blur_px > 0.0) {
    const std::vector<float> weights = blur_weights(sensor.blur_px);
    sharp = blurred(blurred(light, weights, 1, 0), weights, 0, 1);
    field = &sharp;
  }
  Image image;
  image.width = light.width;
  image.height = light.height;
  image.channels = sensor.format.channels();
  image.bits = sensor.format.stored_bits();
  image.pixel_format = sensor.format_name;
  image.bytes.resize(image.row_bytes() * static_cast<std::size_t>(image.height));
  const double largest = std::pow(2.0, sensor.format.bits) - 1.0;
  const double electrons = sensor.full_well * sensor.exposure_us / usual_exposure_us;
  const double levels = std::pow(10.0, sensor.gain_db / 20.0) * largest / sensor.full_well;
  parallel_for(static_cast<std::size_t>(image.height), rows_at_once, [&](std::size_t begin, std::size_t end) {
    for (std::size_t row = begin; row < end; ++row) {
      Random random(seed, first_stream + frame * rows_a_frame + row);
      std::uint8_t* out = image.bytes.data() + row * image.row_bytes();
      for (int x = 0; x < image.width; ++x) {
        const Color& color = field->at(x, static_cast<int>(row));
        for (int channel = 0; channel < image.channels; ++channel) {
          const double caught =
              electrons * static_cast<double>(filtered(color, sensor.format.layout, x, static_cast<int>(row), channel));
          const double noise = std::sqrt(caught + sensor.read_noise * sensor.read_noise) * random.normal();
          const double level =
              std::clamp(std::round(levels * (caught + noise) + sensor.black_level * largest), 0.0, largest);
          const auto value = static_cast<std::uint16_t>(level);
          *out++ = static_cast<std::uint8_t>(value & 0xFFU);
          if (image.bits == 16) *out++ = static_cast<std::uint8_t>(value >> 8U);
        }
      }
    }
  });
  return image;
}

}  // namespace rigcal::sim
