#include "apps/recording/bag_batches.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "core/stops/point_slots.h"
#include "tests/support/bag_bytes.h"
#include "tests/support/files.h"
#include "tests/support/ros_bytes.h"
#include "tests/support/scratch_folder.h"

namespace rigcal {
namespace {

namespace fs = std::filesystem;

constexpr std::int64_t ms = 1'000'000;
constexpr int points_a_cloud = 10'000;  // each tenth of a second: what a MID-40 sees
constexpr int clouds = 10;

// A LiDAR's clouds, each all around, with the times of the points or without.
BagBytes bag_of_clouds(bool timed) {
  BagBytes bag;
  for (int k = 0; k < clouds; ++k) {
    const std::int64_t first_ns = (10'000 + 100 * k) * ms;
    RosBytes data;
    ByteWriter out(data);
    for (int i = 0; i < points_a_cloud; ++i) {
      const double angle = 2.0 * pi * i / points_a_cloud;
      out.write(static_cast<float>(5.0 * std::cos(angle)));
      out.write(static_cast<float>(5.0 * std::sin(angle)));
      out.write(0.3F);
      if (timed) out.write(static_cast<std::uint32_t>(i * 10'000));
    }
    std::vector<CloudField> fields{{"x", 0, 7}, {"y", 4, 7}, {"z", 8, 7}};
    if (timed) fields.push_back({"t", 12, 6});
    const std::uint32_t step = timed ? 16 : 12;
    bag.add("/points", cloud_type, cloud_md5, first_ns + 100 * ms,
            cloud_message(static_cast<std::uint32_t>(k), first_ns + (timed ? 0 : 100 * ms), fields,
                          {1, points_a_cloud, step, step * points_a_cloud, false}, data));
  }
  return bag;
}

struct Kept {
  std::uint64_t points = 0;
  std::uint64_t in_last = 0;  ///< Of those the ones of the last quarter of a turn.
};

Rig rig_of_one_lidar(LidarModel model) {
  Rig rig;
  rig.sensors.emplace_back();
  rig.sensors.back().name = "top";
  rig.sensors.back().lidar.emplace();
  rig.sensors.back().lidar->model = model;
  rig.sensors.back().lidar->topic = "/points";
  return rig;
}

/// Reads all of a bag; what came of it.
IngestSummary read_all(BagBytes& bag, const Rig& rig, BatchSinks sinks) {
  const std::string path = fresh_path("all.bag");
  save_bytes(path, bag.finish());
  auto opened = open_bag_batches(path, rig, std::move(sinks));
  EXPECT_TRUE(opened) << opened.error().message();
  while (*(*opened)->read_some()) continue;
  return (*opened)->summary();
}

// What PointSlots keep of the clouds, 120 000 points a second at most.
Kept kept(bool timed) {
  const std::string path = fresh_path("clouds.bag");
  save_bytes(path, bag_of_clouds(timed).finish());
  const Rig rig = rig_of_one_lidar(LidarModel::other);
  PointSlots slots(120'000.0);
  Kept kept;
  const auto count_slots = [&](bool at_end) {
    while (slots.complete_next(at_end)) {
      for (const RangePoint& point : slots.points(0, slots.last())) {
        const std::int32_t face = point.cell / (44 * 44);  // of a cube: +x, -x, +y, -y
        if (face == 3) ++kept.in_last;
      }
    }
  };
  auto bag = open_bag_batches(path, rig,
                              {[&](PointBatch& batch) {
                                 slots.add(batch);
                                 count_slots(false);
                               },
                               {},
                               {}});
  EXPECT_TRUE(bag) << bag.error().message();
  while (*(*bag)->read_some()) continue;
  count_slots(true);
  kept.points = slots.used();
  return kept;
}

TEST(BagBatches, LoseNoPointsOfASparseLidarToThinning) { EXPECT_EQ(kept(true).points, 1U * clouds * points_a_cloud); }

TEST(BagBatches, WithoutTimesAreSeenAllAround) {
  const Kept some = kept(false);
  EXPECT_NEAR(static_cast<double>(some.points), clouds * 4096.0, clouds);
  EXPECT_NEAR(static_cast<double>(some.in_last), 0.25 * static_cast<double>(some.points), 0.03 * clouds * 4096.0);
}

TEST(BagBatches, OneTimeForAllPointsIsNone) {
  BagBytes bag;
  for (std::uint32_t k = 0; k < 3; ++k)
    bag.add("/points", livox_type, livox_md5, (10'000 + 100 * k) * ms,
            livox_message(k, (10'000 + 100 * k) * ms,
                          {{{1.0F, 2.0F, 3.0F, 4, 0, 0}, 7}, {{1.0F, 2.0F, 3.0F, 4, 0, 0}, 7}}));
  EXPECT_EQ(read_all(bag, rig_of_one_lidar(LidarModel::livox_mid40), {}).topics.at(0).untimed, 3U);
}

// A driver that gathers for a second, without times; its fifth cloud was lost, and the seventh came late.
TEST(BagBatches, ACloudWithoutTimesIsAsLongAsTheTopicsPeriod) {
  BagBytes bag;
  const RosBytes data(12, 0x40);
  for (std::uint32_t k = 0; k < 10; ++k) {
    if (k == 5) continue;
    const std::int64_t end_ns = (10'000 + 1000 * k + (k == 7 ? 300 : 0)) * ms;
    bag.add("/points", cloud_type, cloud_md5, end_ns,
            cloud_message(k, 0, {{"x", 0, 7}, {"y", 4, 7}, {"z", 8, 7}}, {1, 1, 12, 12, false}, data));
  }
  std::vector<std::pair<std::int64_t, std::int64_t>> spans_ms;
  const auto points = [&](PointBatch& batch) {
    EXPECT_TRUE(batch.undivided);
    spans_ms.emplace_back(batch.stamp_ns / ms,
                          (batch.stamp_ns + static_cast<std::int64_t>(batch.shot_interval_ns)) / ms);
  };
  const IngestSummary summary = read_all(bag, rig_of_one_lidar(LidarModel::other), {points, {}, {}});
  const std::vector<std::pair<std::int64_t, std::int64_t>> expected{
      {9000, 10'000},   {10'000, 11'000}, {11'000, 12'000}, {12'000, 13'000}, {13'000, 14'000},
      {14'500, 16'000}, {16'000, 17'300}, {17'000, 18'000}, {18'000, 19'000}};
  EXPECT_EQ(spans_ms, expected);
  ASSERT_EQ(summary.warnings.size(), 2U);
  EXPECT_EQ(summary.warnings[1].find("/points: its clouds take 1.0 s and do not say when"), 0U);
}

TEST(BagBatches, ALoneCloudWithoutTimesIsGivenAtTheEnd) {
  BagBytes bag;
  bag.add("/points", cloud_type, cloud_md5, 10'000 * ms,
          cloud_message(0, 0, {{"x", 0, 7}, {"y", 4, 7}, {"z", 8, 7}}, {1, 1, 12, 12, false}, RosBytes(12, 0x40)));
  int given = 0;
  const auto points = [&](PointBatch& batch) {
    ++given;
    EXPECT_EQ(batch.stamp_ns / ms, 9900);
    EXPECT_EQ(batch.points.size(), 1U);
  };
  read_all(bag, rig_of_one_lidar(LidarModel::other), {points, {}, {}});
  EXPECT_EQ(given, 1);
}

// As bag.write(topic, message, message.header.stamp) makes them.
TEST(BagBatches, ARecordTimeThatIsTheHeadersStampIsNoArrival) {
  const auto first_stamp = [](std::int64_t record_after_ns) {
    BagBytes bag;
    for (std::uint32_t k = 0; k < 3; ++k) {
      const std::int64_t first_ns = (10'000 + 100 * k) * ms;
      bag.add(
          "/points", livox_type, livox_md5, first_ns + record_after_ns,
          livox_message(k, first_ns, {{{1.0F, 2.0F, 3.0F, 4, 0, 0}, 0}, {{1.0F, 2.0F, 3.0F, 4, 0, 0}, 99'000'000}}));
    }
    std::int64_t stamp_ns = 0;
    const auto points = [&](PointBatch& batch) { stamp_ns = batch.stamp_ns; };
    const IngestSummary summary = read_all(bag, rig_of_one_lidar(LidarModel::livox_mid40), {points, {}, {}});
    return std::pair{stamp_ns / ms, summary.warnings.size()};
  };
  EXPECT_EQ(first_stamp(0), (std::pair<std::int64_t, std::size_t>{10'200, 1}));
  EXPECT_EQ(first_stamp(110 * ms), (std::pair<std::int64_t, std::size_t>{10'211, 0})) << "10 ms on its way";
  EXPECT_EQ(first_stamp(60 * ms), (std::pair<std::int64_t, std::size_t>{10'161, 0})) << "clocks that differ";
}

TEST(BagBatches, OneTopicOfSeveralLidarsIsAnError) {
  const auto unfit = [](bool take_turns) {
    BagBytes bag;
    for (std::uint32_t k = 0; k < 10; ++k) {
      const std::int64_t first_ns = (10'000 + 100 * k) * ms;
      const auto lidar = static_cast<std::uint8_t>(take_turns ? k % 2 : k / 5);  // or the driver started anew
      bag.add("/points", livox_type, livox_md5, first_ns + 100 * ms,
              livox_message(k, first_ns, {{{1.0F, 2.0F, 3.0F, 4, 0, 0}, 0}}, lidar));
    }
    return read_all(bag, rig_of_one_lidar(LidarModel::livox_mid40), {}).unfit;
  };
  EXPECT_FALSE(unfit(false));
  const std::optional<Error> error = unfit(true);
  ASSERT_TRUE(error);
  EXPECT_NE(error->message().find("/points has the points of several LiDARs (lidar_id 0, 1), but top is one"),
            std::string::npos)
      << error->message();
}

}  // namespace
}  // namespace rigcal
