#include "core/pipeline/range_stage.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/pipeline/lidar_result.h"
#include "tests/support/biased_room.h"

namespace rigcal {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

SensorResult lidar(const char* name, Status status, double offset_m) {
  SensorResult out;
  out.name = name;
  out.status = status;
  out.range_offset = RangeOffset{offset_m, 0.001};
  return out;
}

// With a cloud whose ranges were corrected.
LidarSolution solution() {
  LidarSolution solved(1, 3);
  solved.ranges = {RangeLaw::constant, {{0.01, 0.0}, {0.02, 0.0}, {0.03, 0.0}}};
  solved.corrected.resize(1);
  return solved;
}

CalibrationResult result_of(std::vector<SensorResult> sensors, LidarSolution solved = solution()) {
  CalibrationResult result;
  result.base = "base";
  result.sensors = std::move(sensors);
  forget_ranges_of_misplaced(result, solved);
  EXPECT_EQ(solved.corrected.empty(), range_words(result).empty());
  EXPECT_EQ(solved.ranges.errors.empty(), range_words(result).empty());
  return result;
}

TEST(RangeOffsets, AreToldOfLidarsThatWerePlaced) {
  const CalibrationResult result = result_of({lidar("base", Status::good, 0.0014), lidar("left", Status::weak, -0.049),
                                              lidar("right", Status::failed, 0.021)});
  EXPECT_TRUE(result.sensors[0].range_offset);
  EXPECT_TRUE(result.sensors[1].range_offset);
  EXPECT_FALSE(result.sensors[2].range_offset);
  EXPECT_THAT(range_words(result),
              AllOf(HasSubstr("base by 1.4 mm (too long), left by 49.0 mm (too short);"), Not(HasSubstr("right"))));
}

TEST(RangeOffsets, AreNotToldOfABaseBesideWhichNobodyWasPlaced) {
  const CalibrationResult result = result_of({lidar("base", Status::good, 0.02), lidar("left", Status::failed, 0.03)});
  EXPECT_FALSE(result.sensors[0].range_offset);
  EXPECT_EQ(range_words(result), "");
}

TEST(RangeOffsets, OfDarkSurfacesAreToldBesideThoseOfAll) {
  SensorResult left = lidar("left", Status::good, -0.004);
  left.dark_offset = RangeOffset{0.012, 0.001};
  SensorResult right = lidar("right", Status::failed, 0.0);
  right.dark_offset = RangeOffset{0.012, 0.001};
  const CalibrationResult result = result_of({lidar("base", Status::good, 0.001), left, right});
  EXPECT_FALSE(result.sensors[2].dark_offset);
  EXPECT_THAT(range_words(result), HasSubstr("reflectivity were corrected for the calibration: base by 1.0 mm (too "
                                             "long), left by 4.0 mm (too short) on white and 8.0 mm (too long) on "
                                             "black;"));
}

TEST(RangeOffsets, AreToldOfALidarThatIsAlone) {
  EXPECT_THAT(range_words(result_of({lidar("base", Status::good, 0.03)})), HasSubstr("base by 30.0 mm"));
}

// By darkness, after which ranges still are (or seem) too long by so much.
bool is_refuted(const std::vector<RangeError>& left, const std::vector<RangeError>& taken_out) {
  const BiasedRoom room(1, left, 500.0);
  LidarSolution solved(8, 2);
  solved.layout = room.layout;
  solved.state = room.truth;
  solved.refined = room.solve(solved.state);
  solved.ranges = {RangeLaw::by_darkness, taken_out};
  return correction_is_refuted(solved);
}

TEST(RangeCorrections, AreRefutedWhereNothingHadBeenWrong) {
  EXPECT_TRUE(is_refuted({{0.0, -0.003}, {0.0, -0.003}}, {{0.0, 0.003}, {0.0, 0.003}}));
  EXPECT_FALSE(is_refuted({{0.0, 0.0}, {0.0, 0.0}}, {{0.0, 0.015}, {0.0, 0.015}}));
  EXPECT_FALSE(is_refuted({{0.0, 0.003}, {0.0, 0.003}}, {{0.0, 0.012}, {0.0, 0.012}})) << "a part of it is left";
}

}  // namespace
}  // namespace rigcal
