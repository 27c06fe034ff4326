#include "core/stops/patch_cutter.h"

#include <gtest/gtest.h>

namespace rigcal {
namespace {

constexpr std::int64_t ms = 1'000'000;

class Clouds final : public PatchSink {
 public:
  void points(int, int, std::span<const Point>) override { ADD_FAILURE() << "timed_points is what is called"; }
  void timed_points(int, int, const ShotTimes& times, std::span<const Point> part) override {
    points_ += part.size();
    first_ns_ = std::min(first_ns_, times.stamp_ns);
  }
  void stop_done(const StopRecord&) override {}

  std::size_t points_ = 0;
  std::int64_t first_ns_ = 1'000'000 * ms;
};

TEST(PatchCutter, TakesAPointsCloudWithoutTimesAsAWholeOrNotAtAll) {
  Clouds clouds;
  PatchCutter cutter(100'000, clouds);
  PointBatch batch;
  batch.undivided = true;
  batch.shots = 1;
  batch.shot_interval_ns = 100.0 * ms;
  batch.points.resize(10);
  for (int i = 0; i < 6; ++i) {
    batch.stamp_ns = 1000 * ms + i * 100 * ms;
    cutter.add(batch);
  }
  // Still from 1150 to 1480 ms: of the six clouds only those at 1200 and 1300 lie inside.
  cutter.not_still_until(1150 * ms, DropReason::moving);
  cutter.still_until(1480 * ms, 0);
  cutter.not_still_until(2000 * ms, DropReason::moving);
  EXPECT_EQ(clouds.points_, 20U);
  EXPECT_EQ(clouds.first_ns_, 1200 * ms);
  EXPECT_EQ(cutter.counts().in_stops, 20U);
  EXPECT_EQ(cutter.counts().dropped[static_cast<std::size_t>(DropReason::moving)], 40U);
}

// A LiDAR's cloud of half a second, in which the stop ends: its rows were seen one after another, each all along.
TEST(PatchCutter, HandsOutTheEndOfAStopBeforeItIsDone) {
  class Done final : public PatchSink {
   public:
    void points(int, int, std::span<const Point> part) override { points_ += part.size(); }
    void stop_done(const StopRecord& stop) override { record_ = stop; }
    std::size_t points_ = 0;
    StopRecord record_;
  } sink;
  PatchCutter cutter(100'000, sink);
  PointBatch batch;
  batch.stamp_ns = 1000 * ms;
  batch.shot_interval_ns = 1.0 * ms;
  batch.points.resize(1000);
  for (std::size_t i = 0; i < 1000; ++i) batch.points[i].shot = static_cast<std::uint16_t>(i % 500);
  cutter.add(batch);
  cutter.still_until(1200 * ms, 0);
  cutter.not_still_until(1300 * ms, DropReason::moving);
  cutter.stop_ended({{0, 900 * ms, 1200 * ms - 1}});
  EXPECT_EQ(sink.points_, 400U);
  EXPECT_EQ(sink.record_.points[0], 400U);
  cutter.not_still_until(2000 * ms, DropReason::moving);
  EXPECT_EQ(sink.points_, 400U);
  EXPECT_EQ(cutter.counts().dropped[static_cast<std::size_t>(DropReason::moving)], 600U);
  EXPECT_EQ(cutter.counts().dropped[static_cast<std::size_t>(DropReason::late)], 0U);
}

PointBatch cloud(std::size_t points, std::int64_t stamp_ns) {
  PointBatch batch;
  batch.undivided = true;
  batch.shot_interval_ns = 1.0 * ms;
  batch.stamp_ns = stamp_ns;
  batch.points.resize(points);
  return batch;
}

std::uint64_t overflow(const PatchCutter& cutter) {
  return cutter.counts().dropped[static_cast<std::size_t>(DropReason::overflow)];
}

TEST(PatchCutter, FillsItsBlocksBeforeItTakesOthers) {
  constexpr std::size_t four_blocks = 4 * 16384;
  Clouds clouds;
  PatchCutter cutter(four_blocks, clouds);
  for (int i = 0; i < 3; ++i) cutter.add(cloud(17'000, i * 100 * ms));
  EXPECT_EQ(overflow(cutter), 0U);
  cutter.still_until(1000 * ms, 0);
  EXPECT_EQ(clouds.points_, 3U * 17'000);
  // All of it is free again.
  for (int i = 0; i < 3; ++i) cutter.add(cloud(20'000, (1100 + i * 100) * ms));
  EXPECT_EQ(overflow(cutter), 0U);
  cutter.still_until(2000 * ms, 0);
  EXPECT_EQ(clouds.points_, 3U * 37'000);
}

// 64 MB of points wait however long it takes; where nobody says anything, the rest of the memory is not filled.
TEST(PatchCutter, HoldsMoreThanUsualOnlyWherePointsComeDensely) {
  constexpr std::size_t at_once = 100'000;
  Clouds clouds;
  PatchCutter dense(8'000'000, clouds);
  for (int i = 0; i < 70; ++i) dense.add(cloud(at_once, i * 20 * ms));
  EXPECT_EQ(overflow(dense), 0U);
  dense.still_until(2000 * ms, 0);
  EXPECT_EQ(clouds.points_, 70 * at_once);
  PatchCutter unheard(8'000'000, clouds);
  for (int i = 0; i < 70; ++i) unheard.add(cloud(at_once, i * 500 * ms));
  EXPECT_GE(overflow(unheard), 29 * at_once);
  EXPECT_LE(overflow(unheard), 32 * at_once);
}

}  // namespace
}  // namespace rigcal
