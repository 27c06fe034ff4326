#include "core/camera/surface_codes.h"

#include <gtest/gtest.h>

#include <set>

namespace rigcal {
namespace {

MapSample sample(int reflectivity, int lidar, const Eigen::Vector3f& normal = Eigen::Vector3f::Zero()) {
  MapSample s;
  s.reflectivity = static_cast<std::uint8_t>(reflectivity);
  s.lidar = static_cast<std::uint8_t>(lidar);
  s.normal_G = normal;
  return s;
}

TEST(SurfaceCodes, RanksAreEvenWithinEachLidar) {
  std::vector<MapSample> samples;
  for (int k = 0; k < 160; ++k) {
    samples.push_back(sample(k / 2, 0));            // 0 .. 79
    samples.push_back(sample(100 + k / 2, 3));      // the same, brighter
    samples.push_back(sample(k < 120 ? 7 : 9, 5));  // two values
  }
  const SurfaceCodes codes = surface_codes(samples);
  std::vector<int> count(reflectivity_ranks, 0);
  for (std::size_t k = 0; k < samples.size(); k += 3) {
    EXPECT_EQ(codes.of_sample[k], codes.of_sample[k + 1]);
    EXPECT_EQ(codes.of_sample[k + 2], k / 3 < 120 ? 6 : 14);
    ++count[codes.of_sample[k]];
  }
  for (const int n : count) EXPECT_EQ(n, 10);
}

TEST(SurfaceCodes, TellApartWhichWayASurfaceFaces) {
  std::set<std::uint8_t> met;
  std::vector<MapSample> samples{sample(0, 0), sample(0, 0, {0.0F, 0.0F, 1.0F}), sample(0, 0, {0.0F, 0.0F, -1.0F})};
  for (int k = 0; k < 8; ++k) {
    const double azimuth = to_rad(45.0 * k + 20.0);
    samples.push_back(sample(0, 0, Eigen::Vector3d(std::cos(azimuth), std::sin(azimuth), 0.1).cast<float>()));
  }
  const SurfaceCodes codes = surface_codes(samples);
  met.insert(codes.of_sample.begin(), codes.of_sample.end());
  EXPECT_EQ(met.size(), static_cast<std::size_t>(facings));
  for (const std::uint8_t code : codes.of_sample) EXPECT_LT(code, surface_codes_count);
}

}  // namespace
}  // namespace rigcal
