#include <gmock/gmock.h>

#include "core/stops/still_detector.h"
#include "tests/core/stops/rig_motion.h"

namespace rigcal {
namespace {

StillFigures figures_of(const RigMotion& motion, const Vector3d& bias_deg_s = Vector3d::Zero()) {
  CollectingListener listener;
  StillDetector detector(StopOptions{}, listener);
  GyroModel gyro;
  gyro.bias_deg_s = bias_deg_s;
  Random random(1);
  for (const ImuSample& sample : read_gyro(motion, gyro, random)) detector.add(sample);
  detector.flush();
  return detector.figures();
}

// Turns of 18 degrees between rests of that length, after a long one and before another.
RigMotion table(int rests, double dwell_s, double swing_rad) {
  RigMotion motion;
  motion.rest(3.0);
  for (int i = 0; i <= rests; ++i) {
    motion.turn(18.0, 30.0, 100.0, swing_rad, 0.3, 4.0);
    motion.rest(i < rests ? dwell_s : 3.0);
  }
  return motion;
}

TEST(BriefRests, AreCountedWhereTheTableDidNotRestLongEnough) {
  for (const double swing_rad : {0.0, 3e-3, 8e-3}) {
    const StillFigures figures = figures_of(table(6, 0.5, swing_rad), Vector3d(0.5, -0.4, 0.3));
    EXPECT_EQ(figures.stops, 2) << swing_rad;
    EXPECT_EQ(figures.brief_rests, 6) << swing_rad;
    EXPECT_NEAR(figures.longest_brief_rest_s, 0.6, 0.25) << swing_rad;
  }
}

TEST(BriefRests, AreCountedWhereNoStopToldTheBias) {
  RigMotion motion;
  for (int i = 0; i < 9; ++i) {
    motion.turn(40.0, 30.0, 100.0, 3e-3, 0.3, 4.0);
    motion.rest(0.4);
  }
  const StillFigures figures = figures_of(motion, Vector3d(0.2, -0.2, 0.2));
  EXPECT_EQ(figures.stops, 0);
  EXPECT_EQ(figures.brief_rests, 8);  // after the last there is no turn
}

TEST(BriefRests, AreNotWhatBecameAStopNorASlowOrSteadyTurn) {
  EXPECT_EQ(figures_of(table(6, 2.5, 3e-3)).brief_rests, 0);
  RigMotion slow;
  slow.rest(3.0);
  for (int i = 0; i < 6; ++i) slow.creep(i % 2 == 0 ? 2.0 : 4.0, 5.0);
  slow.rest(3.0);
  EXPECT_EQ(figures_of(slow).brief_rests, 0);
  RigMotion back_and_forth;
  back_and_forth.rest(3.0);
  for (int i = 0; i < 20; ++i) back_and_forth.turn(i % 2 == 0 ? 20.0 : -15.0, 40.0, 80.0);
  back_and_forth.rest(3.0);
  EXPECT_EQ(figures_of(back_and_forth).brief_rests, 0);
}

TEST(BriefRests, AreNotCountedAcrossASilenceOfTheUnit) {
  RigMotion motion = table(1, 0.5, 0.0);
  CollectingListener listener;
  StillDetector detector(StopOptions{}, listener);
  Random random(1);
  const std::int64_t middle_ns = to_stamp(4.15);
  for (const ImuSample& sample : read_gyro(motion, GyroModel{}, random)) {
    if (std::abs(sample.stamp_ns - middle_ns) > 150'000'000) detector.add(sample);
  }
  detector.flush();
  EXPECT_EQ(detector.figures().brief_rests, 0);
}

}  // namespace
}  // namespace rigcal
