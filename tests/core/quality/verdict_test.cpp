#include "core/quality/verdict.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

namespace rigcal {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

Matrix6d covariance(double rotation_rad, double translation_m) {
  Vector6d variances;
  variances << Vector3d::Constant(rotation_rad * rotation_rad), Vector3d::Constant(translation_m * translation_m);
  return variances.asDiagonal();
}

LidarEvidence sound() {
  LidarEvidence e;
  e.name = "left";
  e.base_name = "avia";
  e.match_score = 0.8;
  e.runner_up_score = 0.3;
  e.used_share = 0.9;
  e.covariance = e.covariance_data_only = covariance(to_rad(0.01), 0.001);
  e.hold_out = 1.1;
  e.hold_out_rms_m = 0.002;
  e.hold_out_start_rms_m = 0.2;
  return e;
}

TEST(JudgeLidar, SoundEvidenceIsGoodWithoutAWord) {
  const Verdict verdict = judge_lidar(sound(), {});
  EXPECT_EQ(verdict.status, Status::good);
  EXPECT_THAT(verdict.reasons, IsEmpty());
}

TEST(JudgeLidar, WhatSettledLateCountsWhereNothingSpeaksAgainstIt) {
  LidarEvidence near = sound();
  near.settled_late = true;
  EXPECT_EQ(judge_lidar(near, {}).status, Status::good);
  LidarEvidence far = near;
  far.from_guess_rad = to_rad(80.0);
  LidarEvidence ambiguous = near;
  ambiguous.runner_up_score = 0.95 * ambiguous.match_score;
  LidarEvidence alone = near;
  alone.used_share = 0.2;
  LidarEvidence disagreeing = near;
  disagreeing.hold_out = 2.5;
  LidarEvidence assumed = near;
  assumed.has_assumed_steps = true;
  for (const LidarEvidence& e : {far, ambiguous, alone, disagreeing, assumed}) {
    const Verdict verdict = judge_lidar(e, {});
    EXPECT_EQ(verdict.status, Status::failed);
    EXPECT_THAT(verdict.reasons, Contains(HasSubstr("did not come to rest")));
  }
}

TEST(JudgeLidar, HalvesThatDifferByChanceOrByLittleAreNoFlaw) {
  LidarEvidence e = sound();
  e.halves = {true, 7, 15.0, to_rad(0.3), 0.03};
  e.base_halves = {true, 7, 300.0, to_rad(0.015), 0.0015};
  EXPECT_EQ(judge_lidar(e, {}).status, Status::good);
}

TEST(JudgeLidar, StopsInWhichTheBaseSawLittleEitherAreNoFlaw) {
  LidarEvidence e = sound();
  e.used_halves = {0.14, 0.74, 6};
  e.base_used_halves = {0.2, 0.8, 6};
  EXPECT_EQ(judge_lidar(e, {}).status, Status::good);
}

struct Flaw {
  const char* name;
  std::function<void(LidarEvidence&)> spoil;
  Status status;
  const char* reason;
};

class JudgeLidarFlaw : public testing::TestWithParam<Flaw> {};

TEST_P(JudgeLidarFlaw, IsNamed) {
  LidarEvidence e = sound();
  GetParam().spoil(e);
  const Verdict verdict = judge_lidar(e, {});
  EXPECT_EQ(verdict.status, GetParam().status);
  ASSERT_THAT(verdict.reasons, ElementsAre(HasSubstr(GetParam().reason)));
  EXPECT_THAT(verdict.reasons[0], HasSubstr("; ")) << "it has no mend";
}

INSTANTIATE_TEST_SUITE_P(
    All, JudgeLidarFlaw,
    testing::Values(
        Flaw{"NoPoints", [](LidarEvidence& e) { e.has_points = false; }, Status::failed, "no points in any stop"},
        Flaw{"NoPointsOfTheBase", [](LidarEvidence& e) { e.base_has_points = false; }, Status::failed,
             "avia, the base, has no points in any stop"},
        Flaw{"NoPointsAsTheBase",
             [](LidarEvidence& e) {
               e.has_points = e.base_has_points = false;
               e.base_name = e.name;
             },
             Status::failed,
             "it has no points in any stop; check its cable, its address and its entry in the rig file "
             "(range in metres, as clouds in files are), or name another base"},
        Flaw{"PointsTooFar",
             [](LidarEvidence& e) {
               e.has_points = false;
               e.saw_too_far = true;
             },
             Status::failed, "all its points in range lie farther than 60 m, where none are used"},
        Flaw{"NotFoundWithoutAGuess", [](LidarEvidence& e) { e.has_guess = e.found = false; }, Status::failed,
             "initial_extrinsics"},
        Flaw{"NotFound", [](LidarEvidence& e) { e.found = false; }, Status::failed, "on those of avia"},
        Flaw{"WrongOrder", [](LidarEvidence& e) { e.stands_at = "mid100_right"; }, Status::weak,
             "it stands where the rig file has mid100_right"},
        Flaw{"SamePlace", [](LidarEvidence& e) { e.same_place_as = "mid100_right"; }, Status::weak,
             "it stands just where mid100_right does"},
        Flaw{"InverseGuess",
             [](LidarEvidence& e) {
               e.guess_is_inverse = true;
               e.from_guess_rad = to_rad(120.0);
             },
             Status::weak, "invert those of the rig file"},
        Flaw{"TurnedFarFromItsGuess", [](LidarEvidence& e) { e.from_guess_rad = to_rad(176.0); }, Status::weak,
             "it ended 176 degrees and 0.00 m from its own initial_extrinsics"},
        Flaw{"FarFromItsGuess", [](LidarEvidence& e) { e.from_guess_m = 0.86; }, Status::weak,
             "it ended 0 degrees and 0.86 m from its own initial_extrinsics"},
        Flaw{"Slipped",
             [](LidarEvidence& e) {
               e.halves = {true, 7, 300.0, to_rad(0.3), 0.004};
             },
             Status::weak, "stops before 7 and from it on give it places that are 4.0 mm and 0.300 degrees apart"},
        Flaw{"BaseSlipped",
             [](LidarEvidence& e) {
               e.base_halves = {true, 6, 300.0, 0.0, 0.02};
             },
             Status::weak, "stops before 6 and from it on give avia, the base, places that are 20.0 mm"},
        Flaw{"FitsTheLaterStopsOnly",
             [](LidarEvidence& e) {
               e.used_halves = {0.14, 0.74, 6};
             },
             Status::weak, "14 % of what it saw before stop 6 lies on common planes, from it on 74 %"},
        Flaw{"BaseFitsTheEarlierStopsOnly",
             [](LidarEvidence& e) {
               e.base_used_halves = {0.7, 0.2, 6};
             },
             Status::weak, "70 % of what avia, the base, saw before stop 6"},
        Flaw{"Wanders",
             [](LidarEvidence& e) {
               e.covariance = covariance(to_rad(0.01), 0.005);
               e.scatter.place = 36.0;
             },
             Status::weak, "single stops differ in it by 6.0 times what noise explains: a mount that does not sit"},
        Flaw{"TurnsToAndFro",
             [](LidarEvidence& e) {
               e.covariance = covariance(to_rad(0.05), 0.001);
               e.scatter.turn = 4.0;
             },
             Status::weak, "single stops differ in it by 2.0 times what noise explains"},
        Flaw{"WandersAlongWhatNothingHolds",
             [](LidarEvidence& e) {
               e.covariance = e.covariance_data_only = covariance(to_rad(0.01), 0.1);
               e.scatter.place = 4.0;
             },
             Status::weak, "add stops that see a surface facing that way"},
        Flaw{"LeftOut", [](LidarEvidence& e) { e.took_part = false; }, Status::failed,
             "all stops in which it saw something were left out"},
        Flaw{"CovarianceIsNoNumber", [](LidarEvidence& e) { e.covariance(3, 3) = std::nan(""); }, Status::failed,
             "do not fix it"},
        Flaw{"PlaceIsNoNumber", [](LidarEvidence& e) { e.T_base_sensor.t.x() = std::nan(""); }, Status::failed,
             "do not fix it"},
        Flaw{"HoldOutIsNoNumber", [](LidarEvidence& e) { e.hold_out = std::nan(""); }, Status::weak,
             "held-out stops disagree"},
        Flaw{"NothingHeldOut",
             [](LidarEvidence& e) {
               e.is_checked = false;
               e.hold_out = e.hold_out_rms_m = e.hold_out_start_rms_m = 0.0;
             },
             Status::weak, "too little was seen in the stops that were held out to check it"},
        Flaw{"NotObservable", [](LidarEvidence& e) { e.observable = false; }, Status::failed, "do not fix it"},
        Flaw{"OpenDirection", [](LidarEvidence& e) { e.covariance(3, 3) = 1.0; }, Status::failed,
             "leave its place along x (forwards) of the base frame open; add an upright surface"},
        Flaw{"NothingFitted", [](LidarEvidence& e) { e.frozen = Vector3d::UnitZ(); }, Status::weak,
             "no surface faces z (up and down) of the base frame"},
        Flaw{"WideTranslation",
             [](LidarEvidence& e) { e.covariance = e.covariance_data_only = covariance(to_rad(0.01), 0.004); },
             Status::weak, "its translation is known to 11.2 mm only"},
        Flaw{"WideRotation",
             [](LidarEvidence& e) { e.covariance = e.covariance_data_only = covariance(to_rad(0.05), 0.001); },
             Status::weak, "its rotation is known to 0.140 degrees only"},
        Flaw{"PriorDecides", [](LidarEvidence& e) { e.covariance_data_only = covariance(to_rad(0.01), 0.2); },
             Status::weak, "not from the data"},
        Flaw{"SettledLateWithoutAGuess",
             [](LidarEvidence& e) {
               e.settled_late = true;
               e.has_guess = false;
               e.last_move_m = 0.0031;
             },
             Status::failed, "still moved it by 3.1 mm"},
        Flaw{"StillMoving", [](LidarEvidence& e) { e.converged = false; }, Status::failed, "still moved it:"},
        Flaw{"StillMovingByTheLast",
             [](LidarEvidence& e) {
               e.converged = false;
               e.last_move_m = 0.0097;
             },
             Status::failed, "still moved it by 9.7 mm and 0.000 degrees"},
        Flaw{"CountedFromAnotherNumberOn",
             [](LidarEvidence& e) {
               e.shifted_stops = StopSpan{1, 20};
               e.base_stops = {0, 19};
             },
             Status::weak, "its clouds are of stops 1 to 20, those of avia of stops 0 to 19"},
        Flaw{"StepsAssumed", [](LidarEvidence& e) { e.has_assumed_steps = true; }, Status::weak, "equal steps"},
        Flaw{"Symmetric", [](LidarEvidence& e) { e.runner_up_score = 0.75; }, Status::weak, "symmetric"},
        Flaw{"FalseMatch", [](LidarEvidence& e) { e.used_share = 0.2; }, Status::weak, "only 20 %"},
        Flaw{"HoldOutDisagrees", [](LidarEvidence& e) { e.hold_out = 2.5; }, Status::weak, "held-out stops disagree"},
        Flaw{"WorseThanTheStart", [](LidarEvidence& e) { e.hold_out_start_rms_m = 0.0015; }, Status::failed, "worse"}),
    [](const auto& flaw) { return std::string(flaw.param.name); });

TEST(JudgeLidar, RestsOnAssumedStepsOnlyNearItsGuess) {
  LidarEvidence e = sound();
  e.has_assumed_steps = true;
  EXPECT_EQ(judge_lidar(e, {}).status, Status::weak);
  e.from_guess_m = 0.57;
  const Verdict verdict = judge_lidar(e, {});
  EXPECT_EQ(verdict.status, Status::failed);
  EXPECT_THAT(verdict.reasons, Contains(HasSubstr("the steps of the table that it rests on were assumed")));
}

// A rig file that is right must not be mended by a place that is wrong.
TEST(JudgeLidar, BlamesTheRigFileOnlyWhereThePlaceIsSure) {
  LidarEvidence far = sound();
  far.from_guess_rad = to_rad(51.0);
  far.from_guess_m = 0.36;
  far.stops = 6;
  far.step_rad = to_rad(6.0);
  const std::vector<std::function<void(LidarEvidence&)>> doubts = {
      [](LidarEvidence& e) { e.converged = false; },
      [](LidarEvidence& e) { e.runner_up_score = 0.75; },
      [](LidarEvidence& e) { e.used_share = 0.3; },
      [](LidarEvidence& e) { e.hold_out = 3.1; },
      [](LidarEvidence& e) { e.hold_out_start_rms_m = 0.0015; },
  };
  for (const std::string other : {"", "c"}) {
    far.stands_at = other;
    EXPECT_THAT(judge_lidar(far, {}).reasons,
                ElementsAre(HasSubstr(other.empty() ? ": these are wrong (axes" : "the units are in the wrong order")));
    for (const auto& doubt : doubts) {
      LidarEvidence e = far;
      doubt(e);
      const std::vector<std::string> reasons = judge_lidar(e, {}).reasons;
      EXPECT_THAT(reasons, Contains(HasSubstr("it ended 51 degrees and 0.36 m from its own initial_extrinsics, but too "
                                              "little is shared")));
      EXPECT_THAT(reasons, Contains(HasSubstr("(there were 6 stops, found 6 degrees from one to the next)")));
      EXPECT_THAT(reasons, Not(Contains(HasSubstr("are wrong"))));
      EXPECT_THAT(reasons, Not(Contains(HasSubstr("wrong order"))));
    }
  }
}

TEST(JudgeLidar, OfFewOrFarStopsOrOfASectorTheRigFileIsNotBlamedWhereNothingFits) {
  LidarEvidence e = sound();
  e.found = false;
  const auto reason_of = [&](int stops, double step_deg, double step_m = 0.0) {
    e.stops = stops;
    e.step_rad = to_rad(step_deg);
    e.step_m = step_m;
    return judge_lidar(e, {}).reasons.at(0);
  };
  EXPECT_THAT(reason_of(2, 180.0),
              HasSubstr("(2 stops, found 180 degrees from one to the next); record stops in smaller"));
  EXPECT_THAT(reason_of(1, 0.0), HasSubstr("(1 stop); record stops"));
  EXPECT_THAT(reason_of(5, 72.0), HasSubstr("only then check initial_extrinsics"));
  EXPECT_THAT(reason_of(6, 6.0), HasSubstr("only then check initial_extrinsics"));
  EXPECT_THAT(reason_of(12, 30.0), HasSubstr("; check initial_extrinsics"));
  EXPECT_THAT(reason_of(12, 0.1, 0.5), HasSubstr("; check initial_extrinsics")) << "a vehicle that drove straight on";
  EXPECT_THAT(reason_of(12, 0.1, 0.002), HasSubstr("only then check initial_extrinsics")) << "a table that stood";
  EXPECT_THAT(reason_of(0, 0.0), HasSubstr("; check initial_extrinsics"));
}

TEST(JudgeLidar, OfASingleStopWithoutAGuessTheOtherMethodIsNamed) {
  LidarEvidence e = sound();
  e.found = e.has_guess = false;
  e.stops = 1;
  EXPECT_THAT(judge_lidar(e, {}).reasons.at(0), HasSubstr("; of a single stop take --method planes"));
  e.stops = 2;
  EXPECT_THAT(judge_lidar(e, {}).reasons.at(0), testing::Not(HasSubstr("--method")));
}

TEST(JudgeLidar, FailsWhatHasAllSignsOfAFalseMatch) {
  LidarEvidence e = sound();
  e.from_guess_rad = to_rad(40.0);
  e.runner_up_score = e.match_score;
  e.hold_out = 2.6;
  const Verdict all = judge_lidar(e, {});
  EXPECT_EQ(all.status, Status::failed);
  EXPECT_THAT(all.reasons, Contains(HasSubstr("disagree by 2.6 times what noise explains: a false match")));
  LidarEvidence near = e;
  near.from_guess_rad = 0.0;
  LidarEvidence alone = e;
  alone.runner_up_score = 0.0;
  LidarEvidence agreeing = e;
  agreeing.hold_out = 1.0;
  for (const LidarEvidence& two : {near, alone, agreeing}) EXPECT_EQ(judge_lidar(two, {}).status, Status::weak);
}

TEST(JudgeLidar, FailsWhatLiesOnNextToNothingAndHasAnotherSignOfAFalseMatch) {
  LidarEvidence e = sound();
  e.used_share = 0.18;
  EXPECT_EQ(judge_lidar(e, {}).status, Status::weak) << "a small common part";
  const auto expect_failed = [](const LidarEvidence& mislaid, const std::string& sign) {
    EXPECT_EQ(judge_lidar(mislaid, {}).status, Status::failed) << sign;
    EXPECT_THAT(judge_lidar(mislaid, {}).reasons, Contains(HasSubstr("lies on common planes, and " + sign)));
  };
  LidarEvidence far = e;
  far.from_guess_m = 1.4;
  expect_failed(far, "it ended 0 degrees and 1.40 m");
  LidarEvidence alone = e;
  alone.has_guess = false;
  expect_failed(alone, "it has no initial_extrinsics");
  LidarEvidence unlike = e;
  unlike.hold_out = 2.5;
  expect_failed(unlike, "held-out stops disagree by 2.5 times");
  for (LidarEvidence shared : {far, alone, unlike}) {
    shared.used_share = 0.25;
    EXPECT_EQ(judge_lidar(shared, {}).status, Status::weak);
  }
}

TEST(JudgeLidar, AsksForWhatTheUserAsksFor) {
  const LidarEvidence e = sound();  // 95 %: 2.8 mm and 0.028 degrees
  EXPECT_EQ(judge_lidar(e, {0.0027, to_rad(0.1)}).status, Status::weak);
  EXPECT_EQ(judge_lidar(e, {0.0029, to_rad(0.1)}).status, Status::good);
  EXPECT_EQ(judge_lidar(e, {0.01, to_rad(0.027)}).status, Status::weak);
  EXPECT_EQ(judge_lidar(e, {0.01, to_rad(0.029)}).status, Status::good);
}

TEST(JudgeLidar, GivesEveryReasonThereIs) {
  LidarEvidence e = sound();
  e.converged = false;
  e.used_share = 0.1;
  e.hold_out = 3.0;
  EXPECT_EQ(judge_lidar(e, {}).reasons.size(), 3U);
}

}  // namespace
}  // namespace rigcal
