#include "apps/experiment/start_experiment.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/json.h"
#include "tests/support/schema_check.h"

namespace rigcal {
namespace {

TEST(TryStarts, CountsRightRigsOfTheCasesAskedFor) {
  StartExperimentOptions options;
  options.rigs = 1;
  options.seed = 3;
  options.cases = {"gyro"};
  SilentReporter silent;
  const auto rows = try_starts(options, {silent});
  ASSERT_TRUE(rows) << rows.error().message();
  ASSERT_EQ(rows->size(), 1U);
  const StartRow& row = rows->front();
  EXPECT_EQ(row.rigs, 1);
  EXPECT_EQ(row.right, 1) << start_experiment_text(*rows);
  EXPECT_EQ(row.lidars, 3);
  EXPECT_EQ(row.lidars_right, 3);
  EXPECT_GT(row.worst_mm, 0.0);
  EXPECT_LT(row.worst_mm, 5.0);
  EXPECT_TRUE(row.misses.empty());
  const auto json = parse_json(start_experiment_json(*rows));
  EXPECT_TRUE(fits_schema("experiment_start.json", json));
  EXPECT_EQ(json["rows"][0]["case"], "gyro");
}

// How one rig went.
StartRow tried(const std::string& kind, std::uint64_t seed) {
  StartExperimentOptions options;
  options.rigs = 1;
  options.seed = seed;
  options.cases = {kind};
  SilentReporter silent;
  const auto rows = try_starts(options, {silent});
  return rows ? rows->front() : StartRow{};
}

// From a guess off by up to 1 m, table tops lie nearer to the floor than the floor does.
TEST(TryStarts, FindsTheHeightThatAGuessIsFarFrom) {
  const StartRow row = tried("guess", 20047);
  EXPECT_EQ(1, row.right) << testing::PrintToString(row.misses);
  // All end a metre from their guesses, which does not flag them: else no rig of this case could be wrong.
  EXPECT_LT(row.right_but_flagged, row.lidars);
}

// What the base alone saw of a drive slid along a wall by half a metre and more (20050), or was taken for a turn in
// place (20071).
TEST(TryStarts, FindsTheWayOfADriveByAllLidars) {
  for (const std::uint64_t seed : {20050U, 20071U}) {
    const StartRow row = tried("figure8", seed);
    EXPECT_EQ(1, row.right) << testing::PrintToString(row.misses);
  }
}

// A height by table tops instead of the floor (9031, 9091), a turn of the stops that one LiDAR alone leaves loose
// (9136), its axis the wrong way round (9104), stops that drifted (9167).
TEST(TryStarts, FindsRigsThatOnlyAllLidarsTogetherTell) {
  for (const std::uint64_t seed : {9031U, 9091U, 9104U, 9136U, 9167U}) {
    const StartRow row = tried("nothing", seed);
    EXPECT_EQ(1, row.right) << testing::PrintToString(row.misses);
  }
}

TEST(TryStarts, EndsWhenTold) {
  SilentReporter silent;
  std::stop_source stop;
  stop.request_stop();
  const auto rows = try_starts({}, {silent, stop.get_token()});
  ASSERT_FALSE(rows);
  EXPECT_EQ(rows.error().kind, ErrorKind::cancelled);
}

}  // namespace
}  // namespace rigcal
