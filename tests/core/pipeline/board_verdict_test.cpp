#include "core/pipeline/board_verdict.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace rigcal {
namespace {

using testing::HasSubstr;

// A board that faces a LiDAR (x forward, y left, z up), turned to the left and leaning backwards by so much.
SE3 board_at(double bearing_deg, double distance, double turn_deg, double lean_deg) {
  Matrix3d facing;
  facing << 0.0, 0.0, 1.0, -1.0, 0.0, 0.0, 0.0, -1.0, 0.0;
  const Matrix3d bearing = exp_so3({0.0, 0.0, to_rad(bearing_deg)});
  return {exp_so3({0.0, 0.0, to_rad(turn_deg)}) * exp_so3({0.0, to_rad(lean_deg), 0.0}) * facing,
          distance * bearing.col(0)};
}

struct Variety {
  double turn_deg = 30.0;
  double lean_deg = 30.0;
  double left_deg = 20.0;
  double right_deg = 20.0;
  double far = 3.0;
  int count = 12;
};

std::string advice(const Variety& variety, bool for_camera = false) {
  BoardAdjustment found;
  found.sensors.resize(2);
  if (for_camera) {
    found.sensors[1].camera.emplace();
    found.sensors[1].T_base_sensor.R << 0.0, 0.0, 1.0, -1.0, 0.0, 0.0, 0.0, -1.0, 0.0;
  }
  for (int k = 0; k < variety.count; ++k) {
    const double bearing = k % 2 == 0 ? variety.left_deg : -variety.right_deg;
    const double distance = k % 3 == 0 ? 2.0 : variety.far;
    BoardPlace place;
    place.T_base_board = board_at(bearing, distance, (k / 2 % 2 == 0 ? 1.0 : -1.0) * variety.turn_deg,
                                  (k / 4 % 2 == 0 ? 1.0 : -1.0) * variety.lean_deg);
    place.sightings.resize(2);
    place.sightings[1].sensor = 1;
    found.places.push_back(place);
  }
  return advice_on_poses(found, 1);
}

TEST(AdviceOnPoses, IsSilentWhereTheyAreVariedEnough) {
  EXPECT_EQ(advice({}), "");
  EXPECT_EQ(advice({}, true), "");
}

TEST(AdviceOnPoses, NamesWhatIsLacking) {
  for (const bool camera : {false, true}) {
    Variety v;
    v.count = 0;
    EXPECT_THAT(advice(v, camera), HasSubstr("to it and to another sensor at once"));
    v = {};
    v.turn_deg = v.lean_deg = 0.0;
    EXPECT_THAT(advice(v, camera), HasSubstr("leans by 30 degrees to all four sides"));
    v = {};
    v.lean_deg = 1.0;
    EXPECT_THAT(advice(v, camera), HasSubstr("leans forwards and backwards"));
    v = {};
    v.turn_deg = 1.0;
    EXPECT_THAT(advice(v, camera), HasSubstr("turned to the left and to the right"));
    v = {};
    v.left_deg = 2.0;
    EXPECT_THAT(advice(v, camera), HasSubstr("at the left"));
    v = {};
    v.right_deg = 2.0;
    EXPECT_THAT(advice(v, camera), HasSubstr("at the right"));
    v = {};
    v.far = 2.1;
    EXPECT_THAT(advice(v, camera), HasSubstr("nearer and farther"));
    v = {};
    v.count = 8;
    EXPECT_THAT(advice(v, camera), HasSubstr("ten or more"));
  }
}

BoardEvidence twelve_boards(double variance) {
  BoardEvidence evidence;
  evidence.name = "side";
  evidence.via = "front";
  evidence.shared = evidence.agreeing = 12;
  evidence.covariance = variance * Matrix6d::Identity();
  return evidence;
}

TEST(JudgeByBoards, PassesOnWhatIsWrongWithTheSensorBetween) {
  BoardEvidence evidence = twelve_boards(1e-10);
  evidence.via_agreeing = 12;
  EXPECT_EQ(judge_by_boards(evidence, {}, "").status, Status::good);
  evidence.via_agreeing = 1;
  Verdict verdict = judge_by_boards(evidence, {}, "");
  EXPECT_EQ(verdict.status, Status::weak);
  EXPECT_THAT(verdict.reasons,
              testing::Contains(HasSubstr("front, whose own place hangs on the board at 1 stop only")));
  evidence.via_failed = true;
  verdict = judge_by_boards(evidence, {}, "");
  EXPECT_EQ(verdict.status, Status::failed);
  EXPECT_THAT(verdict.reasons, testing::Contains(HasSubstr("shares with front, which failed")));
}

TEST(JudgeByBoards, DoesNotAskForPosesThatWereShownAndDisagree) {
  BoardEvidence evidence = twelve_boards(1e-10);
  evidence.agreeing = 2;
  Verdict verdict = judge_by_boards(evidence, {}, "");
  ASSERT_EQ(verdict.reasons.size(), 1U);
  EXPECT_THAT(verdict.reasons[0], HasSubstr("only at 2 of the 12 stops at which it and front saw a board do these "
                                            "agree; check the board and the cameras' intrinsics"));
  evidence.shared = 2;
  verdict = judge_by_boards(evidence, {}, "");
  ASSERT_EQ(verdict.reasons.size(), 1U);
  EXPECT_THAT(verdict.reasons[0], HasSubstr("saw the board together at 2 stops only; show it in ten poses"));
}

TEST(JudgeByBoards, DoubtsAPlaceThatAQuarterOfTheBoardsContradicts) {
  BoardEvidence evidence = twelve_boards(1e-10);
  evidence.agreeing = 10;
  evidence.lost = {3, 7};
  EXPECT_EQ(judge_by_boards(evidence, {}, "").status, Status::good);
  evidence.agreeing = 9;
  evidence.lost = {3, 7, 9};
  EXPECT_EQ(judge_by_boards(evidence, {}, "").status, Status::weak);
  evidence.shared = 16;
  evidence.agreeing = 13;
  EXPECT_EQ(judge_by_boards(evidence, {}, "").status, Status::good);
  evidence.lost_together = true;
  const Verdict verdict = judge_by_boards(evidence, {}, "");
  ASSERT_EQ(verdict.reasons.size(), 1U);
  EXPECT_THAT(verdict.reasons[0], HasSubstr("from stop 3 to stop 9 the board lies elsewhere by it than by front"));
}

TEST(JudgeByBoards, DoubtsAPlaceBetweenHalvesThatAreFarApart) {
  BoardEvidence evidence = twelve_boards(1e-10);
  evidence.halves = {true, 6, 30.0, to_rad(0.01), 0.008};
  const Requirement require{0.01, to_rad(0.1)};
  EXPECT_EQ(judge_by_boards(evidence, require, "").status, Status::good);
  evidence.halves.translation_m = 0.025;
  const Verdict verdict = judge_by_boards(evidence, require, "");
  EXPECT_EQ(verdict.status, Status::weak);
  ASSERT_EQ(verdict.reasons.size(), 1U);
  EXPECT_THAT(verdict.reasons[0], HasSubstr("boards before stop 6 and from it on give places 25.0 mm and"));
  evidence.halves.chi2 = 20.0;
  EXPECT_EQ(judge_by_boards(evidence, require, "").status, Status::good);
}

TEST(JudgeByBoards, DoubtsAFocalLengthThatMovesTheCamera) {
  BoardEvidence evidence = twelve_boards(1e-10);
  const Requirement require{0.01, to_rad(0.1)};
  evidence.focal = {0.004, 0.0015, 0.008, to_rad(0.06)};
  EXPECT_EQ(judge_by_boards(evidence, require, "").status, Status::good);
  evidence.focal = {0.013, 0.0015, 0.027, to_rad(0.06)};
  const Verdict verdict = judge_by_boards(evidence, require, "");
  EXPECT_EQ(verdict.status, Status::weak);
  ASSERT_EQ(verdict.reasons.size(), 1U);
  EXPECT_THAT(verdict.reasons[0], HasSubstr("its focal length is 1.3 % too long in the rig file, which moves it by"));
  evidence.focal.sigma = 0.005;
  EXPECT_EQ(judge_by_boards(evidence, require, "").status, Status::good);
}

TEST(AdviceOnPoses, StandsInTheVerdictWhereMoreIsWanted) {
  const Verdict verdict = judge_by_boards(twelve_boards(1e-4), {}, "add poses at the left of what it sees");
  EXPECT_EQ(verdict.status, Status::weak);
  EXPECT_THAT(verdict.reasons, testing::Contains(HasSubstr("add poses at the left of what it sees")));
}

}  // namespace
}  // namespace rigcal
