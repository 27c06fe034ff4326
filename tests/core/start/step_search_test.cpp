#include "core/start/step_search.h"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>

#include "core/base/parallel.h"
#include "tests/core/start/turning_run.h"

namespace rigcal {
namespace {

TEST(AngleAbout, IsToldOfTurnsAboutThatAxisOnly) {
  const Vector3d axis = Vector3d(0.1, -0.2, 1.0).normalized();
  const auto angle = angle_about(axis, exp_so3(-2.5 * axis) * exp_so3(to_rad(1.0) * Vector3d::UnitX()));
  ASSERT_TRUE(angle);
  EXPECT_NEAR(-2.5, *angle, to_rad(1.0));
  EXPECT_FALSE(angle_about(axis, exp_so3(to_rad(20.0) * axis) * exp_so3(to_rad(5.0) * Vector3d::UnitX())));
}

TEST(HasSlid, WhereNoTurnOfATableCarriesItThatFar) {
  // Half a metre from the axis a quarter turn moves it by 0.71 m.
  EXPECT_FALSE(has_slid({exp_so3(0.5 * pi * Vector3d::UnitZ()), Vector3d(0.5, 0.5, 0.0)}));
  EXPECT_TRUE(has_slid({exp_so3(to_rad(5.0) * Vector3d::UnitZ()), Vector3d(0.5, 0.5, 0.0)}));
}

TEST(MostVoted, IsTheStepThatMostPairsHaveThoughItIsTheBestOfFew) {
  const std::vector<std::vector<StepVote>> pairs{{{to_rad(100.0), 0.5}, {to_rad(30.0), 0.4}},
                                                 {{to_rad(-60.0), 0.5}, {to_rad(31.0), 0.4}},
                                                 {{to_rad(170.0), 0.5}, {to_rad(29.0), 0.4}}};
  const auto step = most_voted(pairs);
  ASSERT_TRUE(step);
  EXPECT_NEAR(30.0, to_deg(*step), 1.0);
  EXPECT_EQ(0.5, vote_for(pairs[0], to_rad(100.0)));
  EXPECT_EQ(0.0, vote_for(pairs[0], to_rad(60.0)));
  EXPECT_FALSE(most_voted({{}, {}}));
}

TEST(RotationsFromSearch, FollowATableTurnedByHandThroughAFullTurn) {
  for (std::uint64_t seed = 1; seed <= 2; ++seed) {
    const TurningRun run(turn_by_hand(seed), seed);
    std::vector<double> scores;
    // The axis is known to a degree and a half.
    const Vector3d axis = exp_so3(Vector3d(0.02, -0.015, 0.0)) * Vector3d::UnitZ();
    const std::vector<Matrix3d> R = rotations_from_search(run.base_patches, run.stops(), axis, {}, scores);
    ASSERT_EQ(run.R_G_base.size(), R.size());
    ASSERT_EQ(run.R_G_base.size(), scores.size());
    EXPECT_EQ(Matrix3d::Identity(), R[0]);
    EXPECT_EQ(1.0, scores[0]);
    for (std::size_t j = 1; j < R.size(); ++j) {
      // Each step adds some tenths of a degree; the alignment that follows takes two degrees.
      EXPECT_LT(to_deg(rotation_distance(run.R_G_base[j], R[j])), 2.0) << "seed " << seed << " stop " << j;
      EXPECT_GE(scores[j], 0.0);
      EXPECT_LE(scores[j], 1.0);
    }
  }
}

TEST(RotationsFromSearch, TurnTheOtherWayToo) {
  std::vector<double> steps = turn_by_hand(3);
  for (double& s : steps) s = -s;
  const TurningRun run(steps, 3);
  std::vector<double> scores;
  const auto R = rotations_from_search(run.base_patches, run.stops(), Vector3d::UnitZ(), {}, scores);
  for (std::size_t j = 1; j < R.size(); ++j) EXPECT_LT(to_deg(rotation_distance(run.R_G_base[j], R[j])), 2.0);
}

TEST(RotationsFromSearch, TakeStepsAsTheyAreWhereTheyAreNotAlike) {
  const TurningRun run({12.0, 41.0, 25.0, 33.0, -19.0}, 4);
  std::vector<double> scores;
  const auto R = rotations_from_search(run.base_patches, run.stops(), Vector3d::UnitZ(), {}, scores);
  for (std::size_t j = 1; j < R.size(); ++j)
    EXPECT_LT(to_deg(rotation_distance(run.R_G_base[j], R[j])), 2.0) << "stop " << j;
}

TEST(RotationsFromSearch, PutTheCommonStepWhereAViewTellsNothingAndSaySo) {
  TurningRun run(turn_by_hand(5), 5);
  run.base_patches[4].surfels.clear();
  std::vector<double> scores;
  const auto R = rotations_from_search(run.base_patches, run.stops(), Vector3d::UnitZ(), {}, scores);
  // Two steps by the marks, each off by what the hand was; then on from there.
  for (std::size_t j = 1; j < R.size(); ++j)
    EXPECT_LT(to_deg(rotation_distance(run.R_G_base[j], R[j])), 8.0) << "stop " << j;
  EXPECT_EQ(0.0, scores[4]);
  EXPECT_EQ(0.0, scores[5]);
}

TEST(RotationsFromSearch, RepeatTheRotationBeforeAStopWithoutAPatch) {
  TurningRun run(turn_by_hand(6), 6);
  run.base_patches.erase(run.base_patches.begin() + 3);
  std::vector<double> scores;
  const auto R = rotations_from_search(run.base_patches, run.stops() + 1, Vector3d::UnitZ(), {}, scores);
  EXPECT_EQ(R[2], R[3]);
  EXPECT_EQ(R[11], R[12]);
  EXPECT_EQ(1.0, scores[3]);
  // Over the gap it looks for twice the common step.
  EXPECT_LT(to_deg(rotation_distance(run.R_G_base[4], R[4])), 4.0);
  EXPECT_EQ(3U, rotations_from_search({}, 3, Vector3d::UnitZ(), {}, scores).size());
}

TEST(RotationsFromSearch, TakeTheStepsThatAreKnownAndNoCutRestForTheTablesStep) {
  std::vector<double> steps;
  for (const double deg : turn_by_hand(8)) {
    steps.push_back(deg);
    steps.push_back(0.05);  // every rest was cut in two: more such steps than turns
    steps.push_back(0.05);
  }
  const TurningRun run(steps, 8);
  std::vector<std::optional<Matrix3d>> known(run.R_G_base.size());
  for (std::size_t j = 1; j < known.size(); ++j) {
    if (j % 3 != 1) known[j] = run.R_G_base[j - 1].transpose() * run.R_G_base[j];
  }
  std::vector<double> scores;
  const auto R = rotations_from_search(run.base_patches, run.stops(), Vector3d::UnitZ(), known, scores);
  for (std::size_t j = 1; j < R.size(); ++j) {
    EXPECT_LT(to_deg(rotation_distance(run.R_G_base[j], R[j])), 2.0) << "stop " << j;
    if (known[j]) {
      EXPECT_EQ(1.0, scores[j]);
    }
  }
}

TEST(RotationsFromSearch, AreTheSameToTheBitForOneAndTwoThreads) {
  const TurningRun run({30.0, 29.0, 31.0}, 7);
  std::vector<double> scores;
  set_thread_count(1);
  const auto one = rotations_from_search(run.base_patches, run.stops(), Vector3d::UnitZ(), {}, scores);
  set_thread_count(2);
  const auto two = rotations_from_search(run.base_patches, run.stops(), Vector3d::UnitZ(), {}, scores);
  for (std::size_t j = 0; j < one.size(); ++j) EXPECT_EQ(one[j], two[j]);
}

}  // namespace
}  // namespace rigcal
