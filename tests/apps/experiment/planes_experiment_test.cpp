#include "apps/experiment/planes_experiment.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "apps/experiment/planes_experiment_text.h"
#include "tests/support/json.h"
#include "tests/support/schema_check.h"

namespace rigcal {
namespace {

TEST(PlanesExperiment, TellsWhichTrialsHaveNoAnswer) {
  PlanesExperiment experiment;
  experiment.table.resize(2);
  experiment.table[1].published_failed = 3;
  experiment.table[1].failed = 2;
  const std::string text = planes_experiment_text(experiment);
  EXPECT_THAT(text, testing::ContainsRegex("3 failed as published  2 failed\n"));
  const auto json = parse_json(planes_experiment_json(experiment));
  EXPECT_TRUE(fits_schema("experiment_planes.json", json));
  EXPECT_EQ(json["table"][0]["published_failed"], 0);
  EXPECT_EQ(json["table"][1]["published_failed"], 3);
  EXPECT_EQ(json["table"][1]["failed"], 2);
}

TEST(TryMountings, FindsThemAndTellsHowLongOneTook) {
  SilentReporter silent;
  const auto figures = try_mountings(4, 1, {silent});
  ASSERT_TRUE(figures) << figures.error().message();
  EXPECT_EQ(figures->trials, 4);
  EXPECT_EQ(figures->right, 4);
  EXPECT_EQ(figures->good, 4);
  EXPECT_GT(figures->median_s, 0.0);
  EXPECT_GE(figures->worst_s, figures->median_s);
}

TEST(TryRightAngles, CallsNoWrongOrderGoodAndFollowsAGuess) {
  SilentReporter silent;
  const auto open = try_right_angles(16, false, 12, {silent});
  ASSERT_TRUE(open);
  EXPECT_GE(open->trials - open->right, 3);
  EXPECT_EQ(open->wrong_good, 0);
  EXPECT_GE(open->weak, 8);
  const auto guessed = try_right_angles(16, true, 12, {silent});
  ASSERT_TRUE(guessed);
  EXPECT_GT(guessed->right, open->right);
  EXPECT_EQ(guessed->wrong_good, 0);
  EXPECT_GE(2 * guessed->good, guessed->right);
}

TEST(TryMountings, EndsWhenTold) {
  SilentReporter silent;
  std::stop_source stop;
  stop.request_stop();
  const auto figures = try_mountings(4, 1, {silent, stop.get_token()});
  ASSERT_FALSE(figures);
  EXPECT_EQ(figures.error().kind, ErrorKind::cancelled);
}

}  // namespace
}  // namespace rigcal
