#include "core/start/step_tree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/base/parallel.h"
#include "core/start/step_match.h"
#include "tests/core/start/turning_run.h"

namespace rigcal {
namespace {

// How the stops are found; all but those of `lost`, to two degrees as seen from the first that is not lost.
void expect_found(const TurningRun& run, const std::vector<std::size_t>& lost = {},
                  const std::vector<std::optional<Matrix3d>>& known = {}) {
  const FoundTurns turns = rotations_by_evidence(run.base_patches, run.stops(), Vector3d::UnitZ(), known);
  ASSERT_EQ(turns.R_G_base.size(), run.R_G_base.size());
  std::optional<std::size_t> first;
  for (std::size_t j = 0; j < run.R_G_base.size(); ++j) {
    const bool is_lost = std::find(lost.begin(), lost.end(), j) != lost.end();
    EXPECT_EQ(is_lost, turns.found[j] == 0) << "stop " << j;
    if (is_lost) continue;
    if (!first) first = j;
    const Matrix3d truth = run.R_G_base[*first].transpose() * run.R_G_base[j];
    const Matrix3d found = turns.R_G_base[*first].transpose() * turns.R_G_base[j];
    EXPECT_LT(to_deg(rotation_distance(truth, found)), 2.0) << "stop " << j;
  }
}

TEST(RotationsByEvidence, FollowStepsThatAreAllUnlike) { expect_found(TurningRun({12.0, 41.0, 25.0, 33.0, -19.0}, 4)); }

TEST(RotationsByEvidence, TakeAStepThatIsUnlikeMostWhereItFitsClearlyBetter) {
  expect_found(TurningRun({20.0, 21.0, 19.0, 45.0, 20.0, 20.0, 35.0, 20.0}, 9));
}

TEST(RotationsByEvidence, StandStillWhereAStopWasRecordedTwice) {
  expect_found(TurningRun({30.0, 31.0, 0.0, 30.0, 29.0, 30.0}, 10));
}

TEST(RotationsByEvidence, LayAStopOnAnEarlierOneWhereTheOneBeforeSawSomethingElse) {
  TurningRun run({15.0, 12.0, 14.0, 26.0, 33.0}, 11);
  // Somebody stood before it.
  Random random(11);
  for (Surfel& s : run.base_patches[2].surfels) {
    s.normal = random_pose(random, 3.0, 0.0).R * Vector3d::UnitZ();
    s.mean = 0.7 * s.mean.normalized();
  }
  expect_found(run, {2});
}

TEST(RotationsByEvidence, LeaveOutWhatHangsOnTheMostByNothing) {
  expect_found(TurningRun({22.0, 34.0, 130.0, 25.0, 15.0, 31.0}, 12), {0, 1, 2});
}

TEST(RotationsByEvidence, TakeTheStepsThatAreKnown) {
  TurningRun run({22.0, 34.0, 130.0, 25.0, 15.0, 31.0}, 12);
  std::vector<std::optional<Matrix3d>> known(run.R_G_base.size());
  known[3] = run.R_G_base[2].transpose() * run.R_G_base[3];
  expect_found(run, {}, known);
}

TEST(RotationsByEvidence, PassOverAStopWithoutAPatch) {
  TurningRun run({15.0, 12.0, 14.0, 26.0, 33.0}, 13);
  run.base_patches.erase(run.base_patches.begin() + 2);
  expect_found(run, {2});
  EXPECT_EQ(3U, rotations_by_evidence({}, 3, Vector3d::UnitZ(), {}).R_G_base.size());
}

TEST(RotationsByEvidence, AreTheSameToTheBitForOneAndTwoThreads) {
  const TurningRun run({30.0, 12.0, 41.0}, 7);
  set_thread_count(1);
  const auto one = rotations_by_evidence(run.base_patches, run.stops(), Vector3d::UnitZ(), {});
  set_thread_count(2);
  const auto two = rotations_by_evidence(run.base_patches, run.stops(), Vector3d::UnitZ(), {});
  for (std::size_t j = 0; j < one.R_G_base.size(); ++j) EXPECT_EQ(one.R_G_base[j], two.R_G_base[j]);
}

TEST(StepView, IsContradictedByATurnThatIsWrong) {
  const TurningRun run({25.0}, 3);
  const StepView before(run.base_patches[0], Vector3d::UnitZ());
  const StepView after(run.base_patches[1], Vector3d::UnitZ());
  const auto X = [&](double deg) {
    const Matrix3d R = exp_so3(to_rad(deg) * Vector3d::UnitZ());
    const Vector3d foot(0.28, -0.12, 0.0);
    return SE3{R, foot - R * foot};
  };
  EXPECT_GT(before.evidence(after.moving(), X(25.0)), 0.2);
  for (const double deg : {10.0, 40.0, 90.0, -25.0}) EXPECT_LT(before.evidence(after.moving(), X(deg)), 0.0) << deg;
  EXPECT_GT(before.share(after.moving(), X(25.0)), before.share(after.moving(), X(10.0)));
}

}  // namespace
}  // namespace rigcal
