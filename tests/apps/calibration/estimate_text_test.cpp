#include "apps/calibration/estimate_text.h"

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

namespace rigcal {
namespace {

TEST(EstimateText, TellsWhichStopsWereLeftOut) {
  StopEstimate estimate;
  estimate.warnings = {"stop 4 is left out: it would be turned otherwise"};
  LidarEstimate& lidar = estimate.lidars.emplace_back();
  lidar.result = {"mid40", Status::weak, {"too few stops"}, {}, {}};
  estimate.advice_text = "turn by 60 degrees";
  EXPECT_THAT(estimate_remarks(estimate), testing::ElementsAre("stop 4 is left out: it would be turned otherwise",
                                                               "mid40: too few stops", "turn by 60 degrees"));
  EXPECT_EQ(estimates_json(std::vector{estimate})[0]["warnings"][0], estimate.warnings[0]);
}

}  // namespace
}  // namespace rigcal
