#include "apps/experiment/base_experiment.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/json.h"
#include "tests/support/schema_check.h"

namespace rigcal {
namespace {

TEST(TryBases, ComparesResultsWithEachLidarAsTheBase) {
  BaseExperimentOptions options;
  options.rigs = 1;
  options.seed = 3;
  options.points = 8000;
  SilentReporter silent;
  const auto rows = try_bases(options, {silent});
  ASSERT_TRUE(rows) << rows.error().message();
  ASSERT_EQ(rows->size(), 1U);
  const BaseRow& row = rows->front();
  EXPECT_EQ(row.lidars, 4);
  EXPECT_EQ(row.failed, 0) << base_experiment_text(*rows);
  // Rounding.
  EXPECT_LT(row.worst_mm, 1e-3);
  EXPECT_LT(row.worst_deg, 1e-5);
  EXPECT_LE(row.good_worst_mm, row.worst_mm);
  const auto json = parse_json(base_experiment_json(*rows));
  EXPECT_TRUE(fits_schema("experiment_base.json", json));
}

TEST(TryBases, AlsoWithNothingKnown) {
  BaseExperimentOptions options;
  options.rigs = 1;
  options.seed = 5;
  options.points = 8000;
  options.with_guess = false;
  options.with_gyro = false;
  SilentReporter silent;
  const auto rows = try_bases(options, {silent});
  ASSERT_TRUE(rows) << rows.error().message();
  ASSERT_EQ(rows->size(), 1U);
  EXPECT_EQ(rows->front().failed, 0);
  EXPECT_LT(rows->front().worst_mm, 1e-3);
  EXPECT_LT(rows->front().worst_deg, 1e-5);
}

TEST(TryBases, CountsALidarThatFailsOnce) {
  BaseExperimentOptions options;
  options.rigs = 1;
  options.seed = 3;
  options.points = 100;
  SilentReporter silent;
  const auto rows = try_bases(options, {silent});
  ASSERT_TRUE(rows) << rows.error().message();
  EXPECT_GT(rows->front().failed, 0);
  EXPECT_LE(rows->front().failed, rows->front().lidars) << base_experiment_text(*rows);
}

TEST(TryBases, EndsWhenTold) {
  SilentReporter silent;
  std::stop_source stop;
  stop.request_stop();
  const auto rows = try_bases({}, {silent, stop.get_token()});
  ASSERT_FALSE(rows);
  EXPECT_EQ(rows.error().kind, ErrorKind::cancelled);
}

}  // namespace
}  // namespace rigcal
