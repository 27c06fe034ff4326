#include "simdata/camera/image_sensor.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

namespace rigcal::sim {
namespace {

LightField even_light(const Color& color, int width = 200, int height = 150) {
  return {width, height, std::vector<Color>(static_cast<std::size_t>(width * height), color)};
}

ImageSensor sensor_of(const std::string& format, double exposure_us = 5000.0) {
  Sensor sensor;
  sensor.name = "camera";
  sensor.camera.emplace();
  sensor.camera->pixel_format = format;
  sensor.camera->exposure_us = exposure_us;
  return *ImageSensor::of(sensor);
}

struct Statistics {
  double mean = 0.0;
  double variance = 0.0;
};

Statistics statistics(const Image& image) {
  Statistics result;
  const double count = image.width * image.height;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) result.mean += image.at(x, y) / count;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) result.variance += std::pow(image.at(x, y) - result.mean, 2) / count;
  return result;
}

// Grey levels and their variance as the electrons say: shot noise, read noise, rounding.
TEST(ImageSensor, HasTheNoiseOfItsElectrons) {
  for (const auto& [light, exposure_us, gain_db] : {std::tuple{0.0F, 5000.0, 0.0},
                                                    {0.1F, 5000.0, 0.0},
                                                    {0.6F, 5000.0, 0.0},
                                                    {0.6F, 2500.0, 0.0},
                                                    {0.2F, 5000.0, 6.0}}) {
    ImageSensor sensor = sensor_of("Mono12", exposure_us);
    sensor.gain_db = gain_db;
    const Statistics seen = statistics(expose(even_light(Color::Constant(light)), sensor, 1, 0));
    const double electrons = 1e4 * static_cast<double>(light) * exposure_us / 5000.0;
    const double levels = 4095.0 / 1e4 * std::pow(10.0, gain_db / 20.0);
    EXPECT_NEAR(levels * electrons + 40.95, seen.mean, 0.02 * std::sqrt(electrons + 64.0) + 0.05) << light;
    const double variance = levels * levels * (electrons + 64.0) + 1.0 / 12.0;
    EXPECT_NEAR(1.0, seen.variance / variance, 0.04) << light;
  }
  const Image full = expose(even_light(Color::Constant(3.0F)), sensor_of("Mono12"), 1, 0);
  EXPECT_EQ(4095, full.at(10, 10));
  EXPECT_EQ(16, full.bits);
}

TEST(ImageSensor, PutsItsColoursWhereTheFormatSays) {
  const Color light(0.7F, 0.4F, 0.15F);
  for (const char* format : {"BayerRG8", "BayerGR8", "BayerGB8", "BayerBG8"}) {
    const Image image = expose(even_light(light), sensor_of(format), 1, 0);
    EXPECT_EQ(1, image.channels);
    EXPECT_EQ(format, image.pixel_format);
    double mean[2][2] = {};
    for (int y = 0; y < image.height; ++y)
      for (int x = 0; x < image.width; ++x) mean[y % 2][x % 2] += image.at(x, y) / (0.25 * image.width * image.height);
    const auto level = [&](char color) { return color == 'R' ? 0.78 * 0.7 : color == 'G' ? 0.4 : 0.68 * 0.15; };
    EXPECT_NEAR(255.0 * (level(format[5]) + 0.01), mean[0][0], 0.5) << format;
    EXPECT_NEAR(255.0 * (level(format[6]) + 0.01), mean[0][1], 0.5) << format;
    // The second row has the colours of the first row's other neighbours: green under what is not green.
    EXPECT_NEAR(format[5] == 'G' ? mean[0][0] : mean[0][1], format[5] == 'G' ? mean[1][1] : mean[1][0], 0.5) << format;
  }
  const Image color = expose(even_light(light), sensor_of("RGB8"), 1, 0);
  EXPECT_EQ(3, color.channels);
  EXPECT_GT(color.at(20, 20, 0), color.at(20, 20, 1));
}

TEST(ImageSensor, BlursByTheWidthItHas) {
  LightField light = even_light(Color::Zero(), 41, 41);
  light.pixels[20 * 41 + 20] = Color::Constant(2.0F);
  ImageSensor sensor = sensor_of("Mono16");
  sensor.read_noise = 0.0;
  sensor.black_level = 0.0;
  sensor.full_well = 1e9;
  const Image image = expose(light, sensor, 1, 0);
  double sum = 0.0;
  double square = 0.0;
  for (int y = 0; y < 41; ++y) {
    for (int x = 0; x < 41; ++x) {
      sum += image.at(x, y);
      square += image.at(x, y) * std::pow(x - 20, 2);
    }
  }
  EXPECT_NEAR(0.6, std::sqrt(square / sum), 0.01);
}

TEST(ImageSensor, RefusesAFormatThatItDoesNotKnow) {
  Sensor sensor;
  sensor.name = "left";
  sensor.camera.emplace();
  sensor.camera->pixel_format = "Mono12Packed";
  const auto refused = ImageSensor::of(sensor);
  ASSERT_FALSE(refused.has_value());
  EXPECT_THAT(refused.error().message(),
              testing::AllOf(testing::HasSubstr("'left'"), testing::HasSubstr("Mono12Packed")));
}

}  // namespace
}  // namespace rigcal::sim
