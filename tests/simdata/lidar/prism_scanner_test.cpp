#include "simdata/lidar/prism_scanner.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace rigcal::sim {
namespace {

std::vector<Vector3d> seconds_of(const PrismScanner& scanner, double seconds) {
  std::vector<Vector3d> all(static_cast<std::size_t>(seconds * scanner.shots_per_s()));
  std::vector<Vector3d> packet(96);
  for (std::size_t i = 0; i + 96 <= all.size(); i += 96) {
    scanner.directions(static_cast<std::int64_t>(i), packet);
    std::copy(packet.begin(), packet.end(), all.begin() + static_cast<std::ptrdiff_t>(i));
  }
  all.resize(all.size() / 96 * 96);
  return all;
}

// The published fields of view; the protocol page's evaluation of the same model is 38.3 and 77.1 x 70.5 degrees, given
// to 0.1 degree, and two seconds of scan come near the rim to 0.05 degrees.
constexpr double field_tolerance_deg = 0.15;

TEST(PrismScanner, Mid40SeesAConeOf38Degrees) {
  Random random(1);
  double widest = 0.0;
  for (const Vector3d& d : seconds_of(*PrismScanner::of(LidarModel::livox_mid40, random), 2.0))
    widest = std::max(widest, std::acos(d.x()));
  EXPECT_NEAR(38.3, 2.0 * to_deg(widest), field_tolerance_deg);
}

struct Field {
  double across_deg = 0.0;
  double upright_deg = 0.0;
};

Field field_of(const PrismScanner& scanner) {
  double left = 0.0;
  double right = 0.0;
  double up = 0.0;
  double down = 0.0;
  for (const Vector3d& d : seconds_of(scanner, 2.0)) {
    const double azimuth = std::atan2(d.y(), d.x());
    const double elevation = std::asin(d.z());
    left = std::max(left, azimuth);
    right = std::min(right, azimuth);
    up = std::max(up, elevation);
    down = std::min(down, elevation);
  }
  return {to_deg(left - right), to_deg(up - down)};
}

TEST(PrismScanner, AviaSees70DegreesAcrossAnd77Upright) {
  Random random(1);
  const Field field = field_of(*PrismScanner::of(LidarModel::livox_avia, random));
  EXPECT_NEAR(70.5, field.across_deg, field_tolerance_deg);
  EXPECT_NEAR(77.1, field.upright_deg, field_tolerance_deg);
}

// Data sheets: 70.4 degrees round, 14.5 x 16.2 and 81.7 x 25.1.
TEST(PrismScanner, TheOtherModelsSeeWhatTheirDataSheetsSay) {
  struct Model {
    LidarModel model;
    Field field;
    int lines;
    double shots_per_s;
  };
  for (const Model& expected : {Model{LidarModel::livox_mid70, {70.4, 70.4}, 1, 100000.0},
                                Model{LidarModel::livox_tele15, {14.5, 16.1}, 6, 240000.0},
                                Model{LidarModel::livox_horizon, {81.7, 25.1}, 6, 240000.0}}) {
    Random random(3);
    const auto scanner = PrismScanner::of(expected.model, random);
    ASSERT_TRUE(scanner.has_value());
    const Field field = field_of(*scanner);
    EXPECT_NEAR(expected.field.across_deg, field.across_deg, field_tolerance_deg) << facts_of(expected.model).word;
    EXPECT_NEAR(expected.field.upright_deg, field.upright_deg, field_tolerance_deg) << facts_of(expected.model).word;
    EXPECT_EQ(expected.lines, scanner->lines());
    EXPECT_EQ(expected.shots_per_s, scanner->shots_per_s());
  }
  Random random(3);
  EXPECT_FALSE(PrismScanner::of(LidarModel::other, random).has_value());
}

TEST(PrismScanner, TurnsAPacketAsItTurnsEachShot) {
  Random random(4);
  for (const PrismScanner& scanner :
       {*PrismScanner::of(LidarModel::livox_avia, random), *PrismScanner::of(LidarModel::livox_mid40, random)}) {
    const std::int64_t first = 60 * static_cast<std::int64_t>(scanner.shots_per_s());  // after a minute
    std::vector<Vector3d> packet(96);
    scanner.directions(first, packet);
    for (std::size_t i = 0; i < packet.size(); ++i) {
      const Vector3d one = scanner.direction(first + static_cast<std::int64_t>(i));
      // Rounding of a hundred turns, and of the time after a minute.
      EXPECT_NEAR(0.0, (packet[i] - one).norm(), 1e-10);
      EXPECT_NEAR(1.0, one.norm(), 1e-12);
    }
  }
}

TEST(PrismScanner, FillsTheFieldRatherThanDrawingOneCurve) {
  Random random(2);
  // In two seconds the scan fills the cone: of cells of one degree inside it nearly all are seen.
  std::vector<bool> seen(40 * 40, false);
  for (const Vector3d& d : seconds_of(*PrismScanner::of(LidarModel::livox_mid40, random), 2.0)) {
    const int column = static_cast<int>(std::floor(to_deg(std::atan2(d.y(), d.x())))) + 20;
    const int row = static_cast<int>(std::floor(to_deg(std::atan2(d.z(), d.x())))) + 20;
    seen[static_cast<std::size_t>(row * 40 + column)] = true;
  }
  const double share = static_cast<double>(std::count(seen.begin(), seen.end(), true)) / (pi * 19.15 * 19.15);
  EXPECT_GT(share, 0.97);
}

}  // namespace
}  // namespace rigcal::sim
