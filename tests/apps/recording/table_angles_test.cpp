#include "apps/recording/table_angles.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "tests/support/noting_reporter.h"
#include "tests/support/scratch_folder.h"

namespace rigcal {
namespace {

using testing::HasSubstr;

constexpr std::int64_t second = 1'000'000'000;

Rig rig_with_axis() {
  Rig rig;
  rig.turntable.emplace();
  rig.turntable->axis = Vector3d(0.0, 0.0, 1.0);
  return rig;
}

const std::vector<Stop> stops{{0, 1 * second, 3 * second}, {1, 5 * second, 7 * second}, {2, 9 * second, 11 * second}};
const std::vector<TableAngle> angles{
    {2 * second, 10.0}, {4 * second, 20.0}, {5 * second, 28.0}, {7 * second, 28.2}, {10 * second, 46.1}};

TEST(TableAngles, AreMeansWithinTheStops) {
  EXPECT_EQ(angle_in_stop(angles, stops[0]), 10.0);
  EXPECT_NEAR(*angle_in_stop(angles, stops[1]), 28.1, 1e-12);
  EXPECT_FALSE(angle_in_stop(angles, {3, 12 * second, 13 * second}).has_value());
  EXPECT_FALSE(angle_in_stop({}, stops[0]).has_value());
}

TEST(TableAngles, OfATableThatCountsWithinATurnAreMeansAcrossItsZero) {
  const std::vector<TableAngle> within_turn{{1 * second, 0.0},  {2 * second, 359.99}, {3 * second, 0.01},
                                            {5 * second, 18.0}, {6 * second, 18.02},  {9 * second, 359.98},
                                            {10 * second, 0.0}, {11 * second, 359.99}};
  EXPECT_NEAR(*angle_in_stop(within_turn, stops[0]), 0.0, 1e-9);
  EXPECT_NEAR(*angle_in_stop(within_turn, stops[2]), 359.99, 1e-9);
  const TableTurns turns = table_turns(rig_with_axis(), within_turn, stops);
  EXPECT_LT(rotation_distance(*turns.R_previous_this[1], exp_so3(Vector3d(0, 0, to_rad(18.01)))), 1e-9);
  EXPECT_LT(rotation_distance(*turns.R_previous_this[2], exp_so3(Vector3d(0, 0, to_rad(-18.02)))), 1e-9);
}

TEST(TableAngles, TurnTheRigAboutItsAxis) {
  const TableTurns turns = table_turns(rig_with_axis(), angles, stops);
  ASSERT_EQ(turns.R_previous_this.size(), 3U);
  EXPECT_FALSE(turns.R_previous_this[0].has_value());
  EXPECT_LT(rotation_distance(*turns.R_previous_this[1], exp_so3(Vector3d(0, 0, to_rad(18.1)))), 1e-12);
  EXPECT_LT(rotation_distance(*turns.R_previous_this[2], exp_so3(Vector3d(0, 0, to_rad(18.0)))), 1e-12);
  Rig without_axis;
  EXPECT_FALSE(table_turns(without_axis, angles, stops).R_previous_this[1].has_value());
}

TEST(TableAngles, OfATableThatCannotBeAskedAreThoseOfItsArrivals) {
  // A line on each arrival, 0.4 s before the rig rests.
  const std::vector<TableAngle> arrivals{{6 * second / 10, 18.0}, {46 * second / 10, 36.5}, {86 * second / 10, 54.0}};
  TableTurns turns = table_turns(rig_with_axis(), arrivals, stops);
  ASSERT_TRUE(turns.R_previous_this[1] && turns.R_previous_this[2]);
  EXPECT_LT(rotation_distance(*turns.R_previous_this[1], exp_so3(Vector3d(0, 0, to_rad(18.5)))), 1e-12);
  EXPECT_LT(rotation_distance(*turns.R_previous_this[2], exp_so3(Vector3d(0, 0, to_rad(17.5)))), 1e-12);
  // The second says nothing of where it arrives; the third is still on its way when it is heard last.
  const std::vector<TableAngle> lost{{6 * second / 10, 18.0}, {85 * second / 10, 52.0}, {86 * second / 10, 53.0}};
  turns = table_turns(rig_with_axis(), lost, stops);
  EXPECT_FALSE(turns.R_previous_this[1] || turns.R_previous_this[2]);
  const std::vector<TableAngle> long_ago{{0, 18.0}, {46 * second / 10, 36.5}};
  const std::vector<Stop> late{{0, 1 * second, 2 * second}, {1, 9 * second, 11 * second}};
  EXPECT_FALSE(table_turns(rig_with_axis(), long_ago, late).R_previous_this[1]);
}

TEST(TableAngles, FillInWhatNobodyElseKnowsAndAreNotBelievedAgainstTheGyro) {
  const TableTurns turns = table_turns(rig_with_axis(), angles, stops);
  const Matrix3d gyro = exp_so3(Vector3d(0.01, 0.0, to_rad(18.3)));
  std::vector<std::optional<Matrix3d>> known{std::nullopt, gyro, std::nullopt};
  EXPECT_EQ(merge_table_turns(turns, known), "");
  EXPECT_EQ(*known[1], gyro);
  EXPECT_EQ(*known[2], *turns.R_previous_this[2]);
  known[2] = exp_so3(Vector3d(0.0, 0.0, to_rad(-18.0)));
  const Matrix3d other_way = *known[2];
  EXPECT_THAT(merge_table_turns(turns, known), HasSubstr("about 1 turns, by up to 36.0 degrees"));
  EXPECT_EQ(*known[2], other_way);
}

TEST(TableAngles, OfASession) {
  const auto folder = scratch_folder("table_angles");
  NotingReporter notes;
  EXPECT_TRUE(session_table_angles(folder.string(), notes).empty());
  std::ofstream(folder / "turntable.csv") << "stamp_ns,angle_deg\n5,1.5\n";
  EXPECT_EQ(session_table_angles(folder.string(), notes).size(), 1U);
  EXPECT_THAT(notes.warnings, testing::IsEmpty());
}

TEST(TableAngles, ThatCannotBeReadAreAWarning) {
  const auto folder = scratch_folder("table_angles");
  NotingReporter notes;
  std::ofstream(folder / "turntable.csv") << "nonsense\n";
  EXPECT_TRUE(session_table_angles(folder.string(), notes).empty());
  std::ofstream(folder / "turntable.csv") << "stamp_ns,angle_deg\n5,0\n7,18.0\n" << std::string(40, '\0');
  EXPECT_EQ(session_table_angles(folder.string(), notes).size(), 2U);
  EXPECT_THAT(notes.warnings, testing::ElementsAre(HasSubstr("turntable.csv:1"), HasSubstr("was left out")));
}

}  // namespace
}  // namespace rigcal
