#include "core/stops/point_slots.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "core/geometry/se3.h"

namespace rigcal {
namespace {

constexpr std::int64_t ms = 1'000'000;
constexpr double most_points_per_s = 120'000.0;
constexpr std::int32_t cells_a_face = 44 * 44;  // of RangePoint: faces +x, -x, +y, -y

Point around(double turn) {
  const double angle = 2.0 * pi * turn;
  return {static_cast<float>(5.0 * std::cos(angle)), static_cast<float>(5.0 * std::sin(angle)), 0.3F, 0, 0, 0};
}

// A packet of `shots` shots, `points_a_shot` (1/2: every second one returns) points each.
PointBatch packet(int shots, double shots_per_s, double points_a_shot) {
  PointBatch batch;
  batch.stamp_ns = 1000 * ms;
  batch.shots = static_cast<std::uint16_t>(shots);
  batch.shot_interval_ns = 1e9 / shots_per_s;
  const int count = static_cast<int>(shots * points_a_shot);
  for (int i = 0; i < count; ++i) {
    batch.points.push_back(around(0.1));
    batch.points.back().shot = static_cast<std::uint16_t>(i / points_a_shot);
  }
  return batch;
}

// A turn of a LiDAR as a bag has it: the points of 0.1 s, in the order in which they were seen.
PointBatch cloud(int points, bool timed) {
  PointBatch batch;
  batch.stamp_ns = 1000 * ms;
  batch.undivided = !timed;
  batch.shot_interval_ns = timed ? 100.0 * ms / 65535 : 100.0 * ms;
  for (int i = 0; i < points; ++i) {
    batch.points.push_back(around(static_cast<double>(i) / points));
    if (timed) batch.points.back().shot = static_cast<std::uint16_t>(std::lround(65535.0 * i / (points - 1)));
  }
  return batch;
}

// How many points of those batches are kept, each of them in its own time.
double kept(PointBatch batch, double points_per_s, int batches = 1) {
  PointSlots slots(points_per_s);
  for (int i = 0; i < batches; ++i) {
    slots.add(batch);
    batch.stamp_ns += 100 * ms;
    while (slots.complete_next(false)) continue;
  }
  return static_cast<double>(slots.used());
}

// The points kept of an only batch, by quarter of the view.
std::array<int, 4> kept_by_quarter(const PointBatch& batch) {
  PointSlots slots(most_points_per_s);
  slots.add(batch);
  PointBatch later = batch;
  later.stamp_ns += 500 * ms;
  slots.add(later);
  std::array<int, 4> quarters{};
  while (slots.complete_next(false) && slots.start_ns(slots.last()) < batch.stamp_ns + 100 * ms) {
    for (const RangePoint& point : slots.points(0, slots.last()))
      ++quarters[static_cast<std::size_t>(point.cell / cells_a_face)];
  }
  return quarters;
}

TEST(PointSlots, ThinPacketsByTheirShotsWhateverReturns) {
  EXPECT_NEAR(kept(packet(96, 240'000.0, 1.0), most_points_per_s, 100), 0.5 * 9600, 1.0);
  EXPECT_NEAR(kept(packet(96, 240'000.0, 0.5), most_points_per_s, 100), 0.5 * 4800, 1.0);
  EXPECT_NEAR(kept(packet(48, 240'000.0, 2.0), most_points_per_s, 100), 0.5 * 9600, 1.0);
  EXPECT_EQ(kept(packet(100, 100'000.0, 1.0), most_points_per_s, 10), 1000.0);
}

TEST(PointSlots, ThinCloudsByTheirPoints) {
  EXPECT_EQ(kept(cloud(10'000, true), most_points_per_s), 10'000.0) << "100 000 points/s, as in packets";
  EXPECT_NEAR(kept(cloud(10'000, true), 0.3 * 1e5), 3000.0, 1.0);
  EXPECT_NEAR(kept(cloud(60'000, true), most_points_per_s), 12'000.0, 1.0);
  EXPECT_NEAR(kept(cloud(200'000, true), most_points_per_s), 12'000.0, 1.0);
}

TEST(PointSlots, KeepOfACloudWithoutTimesPointsAllAround) {
  const PointBatch untimed = cloud(10'000, false);
  PointBatch all_at_once = cloud(10'000, true);
  all_at_once.shot_interval_ns = 0.0;
  for (const PointBatch& batch : {untimed, all_at_once}) {
    for (const int points : kept_by_quarter(batch)) EXPECT_NEAR(points, 1024, 2);
  }
  EXPECT_EQ(kept(cloud(2'000, false), most_points_per_s), 2'000.0);
  EXPECT_NEAR(kept(cloud(10'000, false), 0.2 * 1e5), 2'000.0, 1.0) << "fewer than fit";
}

}  // namespace
}  // namespace rigcal
