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

}  // namespace
}  // namespace rigcal
