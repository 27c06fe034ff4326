#include "apps/experiment/sigma_experiment.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/json.h"
#include "tests/support/schema_check.h"

namespace rigcal {
namespace {

TEST(SigmaFigures, CountErrorsInsideTheEllipsoidsByScene) {
  SigmaRow row;
  for (const double nees : {1.0, 6.9, 7.1, 12.5, 12.7})
    row.trials.push_back({"room", nees, 0.001, 0.001, Status::good});
  row.trials.push_back({"sparse", 100.0, 0.02, 0.01, Status::weak});
  row.trials.push_back({"sparse", 1.0, 0.002, 0.001, Status::weak});
  const SigmaFigures room = sigma_figures(row, "room");
  EXPECT_EQ(room.lidars, 5);
  EXPECT_NEAR(room.mean_nees, 8.04, 1e-9);
  EXPECT_NEAR(room.within_68, 0.4, 1e-9);
  EXPECT_NEAR(room.within_95, 0.8, 1e-9);
  const SigmaFigures all = sigma_figures(row, "");
  EXPECT_EQ(all.lidars, 7);
  EXPECT_EQ(all.good, 5);
  EXPECT_EQ(all.false_alarms, 1);
  EXPECT_NEAR(all.within_95, 5.0 / 7.0, 1e-9);
  EXPECT_NEAR(all.good_within_95, 0.8, 1e-9);
  EXPECT_EQ(sigma_figures(row, "courtyard").lidars, 0);
}

TEST(TrySigmas, ErrorsAreAsLargeAsSigmaSaysAlsoWithWrongRanges) {
  SigmaExperimentOptions options;
  options.rigs = 3;
  options.points = 8000;
  SilentReporter silent;
  const auto rows = try_sigmas(options, {silent});
  ASSERT_TRUE(rows) << rows.error().message();
  ASSERT_EQ(rows->size(), 2U);
  for (const SigmaRow& row : *rows) {
    const SigmaFigures all = sigma_figures(row, "");
    EXPECT_EQ(all.lidars + row.failed, 9);
    EXPECT_GT(all.lidars, 6);
    // Nine squares of six degrees of freedom; without a thought for ranges the second row has hundreds.
    EXPECT_LT(all.mean_nees, 14.0) << sigma_experiment_text(*rows);
  }
  const auto json = parse_json(sigma_experiment_json(*rows));
  EXPECT_TRUE(fits_schema("experiment_sigma.json", json));
  EXPECT_THAT(nees_svg(*rows), testing::StartsWith("<svg xmlns"));
}

TEST(TrySigmas, EndWhenTold) {
  SilentReporter silent;
  std::stop_source stop;
  stop.request_stop();
  const auto rows = try_sigmas({}, {silent, stop.get_token()});
  ASSERT_FALSE(rows);
  EXPECT_EQ(rows.error().kind, ErrorKind::cancelled);
}

}  // namespace
}  // namespace rigcal
