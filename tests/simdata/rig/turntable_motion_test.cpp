#include "simdata/rig/turntable_motion.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "simdata/rig/imu_model.h"

namespace rigcal::sim {
namespace {

TurntableMotion motion_of(std::uint64_t seed, TurntableOptions options = {}) {
  Random random(seed);
  return TurntableMotion({Matrix3d::Identity(), Vector3d(1.0, 2.0, 1.3)}, options, random);
}

TEST(TurntableMotion, TurnsTheTableOnceRoundInStopsOfTheDwellAskedFor) {
  const TurntableMotion motion = motion_of(1);
  ASSERT_EQ(20, motion.stop_count());
  double turned_deg = 0.0;
  for (int k = 0; k + 1 < motion.stop_count(); ++k) {
    const Matrix3d step = motion.T_G_base_at_stop(k).R.transpose() * motion.T_G_base_at_stop(k + 1).R;
    turned_deg += to_deg(log_so3(step).norm());
    EXPECT_NEAR(k == 0 ? 3.0 : 2.0, motion.stop_end_s(k) - motion.stop_start_s(k), 1e-12);
  }
  // 19 steps of 18 degrees, each with a sigma of 1.2: five sigma of the sum.
  EXPECT_NEAR(342.0, turned_deg, 5.0 * 1.2 * std::sqrt(19.0));
}

TEST(TurntableMotion, StandsStillOnceTheSwingIsOver) {
  const TurntableMotion motion = motion_of(2);
  for (int k = 0; k < motion.stop_count(); ++k) {
    const SE3 settled = motion.T_scene_base_at_stop(k);
    const SE3 late = motion.T_scene_base(motion.stop_end_s(k));
    // 4.5 mrad die away by exp(-2 / 0.15) to 7e-9 rad.
    EXPECT_LT(rotation_distance(settled.R, late.R), 2e-8);
    EXPECT_LT((settled.t - late.t).norm(), 2e-8);
  }
}

TEST(TurntableMotion, SwingsByAFewMilliradiansAfterATurn) {
  const TurntableMotion motion = motion_of(3);
  double widest = 0.0;
  for (double since = 0.0; since < 0.5; since += 0.005) {
    const Matrix3d now = motion.T_scene_base(motion.stop_start_s(4) + since).R;
    widest = std::max(widest, rotation_distance(now, motion.T_scene_base_at_stop(4).R));
  }
  EXPECT_GT(widest, 0.5e-3);
  EXPECT_LT(widest, 6e-3);
}

TEST(TurntableMotion, KeepsStopsOnOneAxisButForTheJitter) {
  const TurntableMotion motion = motion_of(4);
  const Vector3d axis = motion.axis_in_base();
  const Vector3d foot = motion.axis_point_in_base();
  EXPECT_NEAR(0.0, axis.dot(foot), 1e-12);
  EXPECT_GT(foot.norm(), 0.09);
  for (int k = 1; k < motion.stop_count(); ++k) {
    const SE3 T = motion.T_G_base_at_stop(k);
    // Jitter 0.01 degrees and 0.3 mm an axis and stop, two stops, five sigma; at 0.3 m 0.01 degrees are 0.05 mm.
    EXPECT_LT(to_deg(std::acos(std::min(1.0, axis.dot(T.R * axis)))), 5.0 * 0.01 * 2.0);
    EXPECT_LT((T * foot - foot).norm(), 5.0 * 0.35e-3 * std::sqrt(6.0));
  }
}

TEST(TurntableMotion, HasAGyroThatIntegratesToItsPoses) {
  const TurntableMotion motion = motion_of(5);
  const SE3 T_base_sensor{exp_so3({0.1, -0.2, 0.4}), Vector3d(0.1, 0.0, -0.1)};
  const ImuModel imu(motion, T_base_sensor, ImuErrors{});
  const double step = 1e-3;
  const double begin = motion.stop_end_s(0) - 0.1;
  const double end = motion.stop_start_s(1) + 1.0;
  Matrix3d R = (motion.T_scene_base(begin) * T_base_sensor).R;
  const int steps = static_cast<int>(std::lround((end - begin) / step));
  for (int i = 0; i < steps; ++i) R = R * exp_so3(step * imu.turn_rate(begin + (i + 0.5) * step));
  // Midpoint rule at 1 ms over swings of 4 Hz: below 1e-6 rad.
  EXPECT_LT(rotation_distance(R, (motion.T_scene_base(begin + steps * step) * T_base_sensor).R), 1e-6);
}

TEST(TurntableMotion, HasAnAccelerometerThatFeelsGravityAtRestAndTheSwingAfterATurn) {
  const TurntableMotion motion = motion_of(6);
  const ImuModel imu(motion, SE3{}, ImuErrors{});
  const Vector3d up = motion.T_scene_base_at_stop(3).R.transpose() * Vector3d::UnitZ();
  EXPECT_LT((imu.specific_force_g(motion.stop_end_s(3) - 0.05) - up).norm(), 1e-5);
  double strongest = 0.0;
  for (double since = 0.0; since < 1.5; since += 0.01)
    strongest = std::max(strongest, (imu.specific_force_g(motion.stop_end_s(3) + since) - up).norm());
  // 0.1 to 0.3 m from the axis at up to 0.4 rad/s and 0.75 rad/s^2: some milli-g, and the axis tilts gravity.
  EXPECT_GT(strongest, 1e-3);
  EXPECT_LT(strongest, 0.1);
}

TEST(TurntableMotion, KeepsEverythingElseOfARunWhenItIsTroubled) {
  TurntableOptions troubled;
  troubled.vibration.amplitude_rad = 1e-4;
  troubled.bumps = {{2, 0.7, 1e-3}};
  const TurntableMotion motion = motion_of(7, troubled);
  const TurntableMotion quiet = motion_of(7);
  for (const int k : {0, 5, 19}) {
    EXPECT_EQ(quiet.T_scene_base_at_stop(k).R, motion.T_scene_base_at_stop(k).R);
    EXPECT_EQ(quiet.T_scene_base_at_stop(k).t, motion.T_scene_base_at_stop(k).t);
  }
}

TEST(TurntableMotion, KeepsItsPosesWhereItDwellsOtherwise) {
  TurntableOptions uneven;
  uneven.dwell_range_s = {{1.0, 30.0}};
  const TurntableMotion motion = motion_of(7, uneven);
  const TurntableMotion even = motion_of(7);
  EXPECT_NE(even.dwell_s(5), motion.dwell_s(5));
  for (const int k : {0, 5, 19}) {
    EXPECT_EQ(even.T_scene_base_at_stop(k).R, motion.T_scene_base_at_stop(k).R);
    EXPECT_EQ(even.T_scene_base_at_stop(k).t, motion.T_scene_base_at_stop(k).t);
  }
}

TEST(TurntableMotion, TurnsByUnequalStepsWhereThatIsAskedFor) {
  TurntableOptions options;
  options.stops = 200;
  options.step_range_deg = {{10.0, 60.0}};
  const TurntableMotion motion = motion_of(7, options);
  double least = 360.0;
  double most = 0.0;
  double before = 0.0;
  for (int k = 1; k < motion.stop_count(); ++k) {
    const double angle = to_deg(motion.angle_rad(motion.stop_start_s(k)));
    least = std::min(least, angle - before);
    most = std::max(most, angle - before);
    before = angle;
  }
  EXPECT_GE(least, 10.0 - 1e-9);
  EXPECT_LT(least, 12.0);
  EXPECT_LE(most, 60.0 + 1e-9);
  EXPECT_GT(most, 58.0);
  // Nothing else comes out otherwise.
  options.step_range_deg.reset();
  EXPECT_EQ(motion_of(7, options).T_scene_base_at_stop(0).R, motion.T_scene_base_at_stop(0).R);
  EXPECT_EQ(motion_of(7, options).axis_in_base(), motion.axis_in_base());
}

TEST(TurntableMotion, CreepsOnAtTheRateAskedFor) {
  TurntableOptions options;
  options.creep_rad_per_s = 2e-4;
  const TurntableMotion motion = motion_of(8, options);
  const double end = motion.stop_end_s(6);
  const Matrix3d early = motion.T_scene_base_settled(end - 1.5).R;
  const Vector3d crept = log_so3(early.transpose() * motion.T_scene_base_settled(end).R);
  EXPECT_NEAR(3e-4, crept.dot(motion.axis_in_base()), 1e-9);
  EXPECT_NEAR(3e-4, crept.norm(), 1e-7);  // the jitter tilts the base by 0.01 degrees
  const SE3 middle = motion.T_scene_base_settled(0.5 * (motion.stop_start_s(6) + end));
  EXPECT_EQ(middle.R, motion.T_scene_base_at_stop(6).R);
  EXPECT_TRUE(motion.moves_at_rest());
  EXPECT_FALSE(motion_of(8).moves_at_rest());
}

TEST(TurntableMotion, TremblesWithTheAmplitudeAndFrequencyAskedFor) {
  TurntableOptions options;
  options.swing_rad = 0.0;
  options.vibration = {3e-4, 20.0};
  const TurntableMotion motion = motion_of(9, options);
  const Matrix3d settled = motion.T_scene_base_at_stop(4).R;
  double widest = 0.0;
  int zero_crossings = 0;
  Vector3d first = Vector3d::Zero();
  double last = 0.0;
  for (int i = 0; i < 10000; ++i) {
    const double time = motion.stop_start_s(4) + 0.5 + 1e-4 * i;
    const Vector3d off = log_so3(settled.transpose() * motion.T_scene_base(time).R);
    widest = std::max(widest, off.norm());
    if (first.norm() < 1e-5) first = off;
    const double along = off.dot(first);
    if (along * last < 0.0) ++zero_crossings;
    if (along != 0.0) last = along;
  }
  EXPECT_NEAR(3e-4, widest, 1e-6);
  EXPECT_NEAR(40, zero_crossings, 1);
}

TEST(TurntableMotion, OvershootsAndReturnsBeforeTheStopStarts) {
  TurntableOptions options;
  options.overshoot_rad = 0.02;
  const TurntableMotion motion = motion_of(10, options);
  const double gap = motion.stop_start_s(3) - motion.stop_end_s(2);
  EXPECT_NEAR(options.turn_s + options.overshoot_return_s, gap, 1e-12);
  const Matrix3d from = motion.T_scene_base_at_stop(2).R;
  const auto turned = [&](double time) {
    return log_so3(from.transpose() * motion.T_scene_base_settled(time).R).dot(motion.axis_in_base());
  };
  const double arrived = turned(motion.stop_start_s(3));
  EXPECT_NEAR(0.02, turned(motion.stop_end_s(2) + options.turn_s) - arrived, 1e-5);
  EXPECT_NEAR(0.0, turned(motion.stop_end_s(3)) - arrived, 1e-9);
}

TEST(TurntableMotion, LeansOverWhenItIsBumpedUntilItTurnsOn) {
  TurntableOptions options;
  options.bumps = {{2, 0.9, 4e-3}};
  const TurntableMotion motion = motion_of(11, options);
  const double at = motion.stop_start_s(2) + 0.9;
  const Matrix3d before = motion.T_scene_base_settled(at - 0.01).R;
  const Matrix3d after = motion.T_scene_base_settled(at + TurntableMotion::bump_s).R;
  EXPECT_NEAR(4e-3, rotation_distance(before, after), 1e-9);
  EXPECT_LT(rotation_distance(after, motion.T_scene_base_settled(motion.stop_end_s(2)).R), 1e-9);
  EXPECT_EQ(motion_of(11).T_scene_base_at_stop(3).R, motion.T_scene_base_at_stop(3).R);

  const std::vector<Rest> rests = motion.rests();
  ASSERT_EQ(21U, rests.size());
  EXPECT_EQ(2, rests[2].stop);
  EXPECT_EQ(2, rests[3].stop);
  EXPECT_NEAR(at, rests[2].end_s, 1e-12);
  EXPECT_NEAR(at + TurntableMotion::bump_s, rests[3].start_s, 1e-12);
  EXPECT_NEAR(motion.stop_end_s(2), rests[3].end_s, 1e-12);
}

TEST(TurntableMotion, DwellsShortAndLongWhereThatIsAskedFor) {
  TurntableOptions options;
  options.stops = 400;
  options.dwell_range_s = {{1.0, 30.0}};
  const TurntableMotion motion = motion_of(12, options);
  int below = 0;
  double shortest = 100.0;
  double longest = 0.0;
  for (int k = 0; k < motion.stop_count(); ++k) {
    below += motion.dwell_s(k) < std::sqrt(30.0) ? 1 : 0;
    shortest = std::min(shortest, motion.dwell_s(k));
    longest = std::max(longest, motion.dwell_s(k));
  }
  EXPECT_GE(shortest, 1.0);
  EXPECT_LT(shortest, 1.2);
  EXPECT_LE(longest, 30.0);
  EXPECT_GT(longest, 25.0);
  EXPECT_NEAR(200, below, 50);  // five sigma of 400 even throws
}

TEST(TurntableMotion, DrivesAFigureOfEightWhereThatIsAskedFor) {
  TurntableOptions options;
  options.stops = 32;
  options.drive_m = 3.0;
  options.axis_tilt_deg = 0.0;
  options.base_tilt_deg = 0.0;
  options.base_offset_max = options.base_offset_min = 0.0;
  options.step_sigma_deg = 0.0;
  const TurntableMotion motion = motion_of(7, options);
  const auto place = [&](int k) { return Vector3d(motion.T_scene_base_at_stop(k % 32).t - Vector3d(1.0, 2.0, 1.3)); };
  EXPECT_NEAR((place(8) - Vector3d(3.0, 0.0, 0.0)).norm(), 0.0, 0.01);
  EXPECT_NEAR((place(24) - Vector3d(-3.0, 0.0, 0.0)).norm(), 0.0, 0.01);
  // It goes through its crossing twice, and across the first way the second time.
  EXPECT_NEAR(place(16).norm(), 0.0, 0.01);
  double least = 0.0;
  double most = 0.0;
  double heading = 0.0;
  for (int k = 0; k < 32; ++k) {
    const Vector3d chord = place(k + 1) - place(k);
    EXPECT_LT(chord.norm(), 1.0) << k;
    // Its way goes 45 degrees to the left of x.
    const Vector3d ahead = motion.T_scene_base_at_stop(k).R * Vector3d(1.0, 1.0, 0.0).normalized();
    EXPECT_GT(ahead.dot(chord.normalized()), 0.9) << k;
    heading = motion.angle_rad(motion.stop_start_s(k));
    least = std::min(least, heading);
    most = std::max(most, heading);
  }
  EXPECT_NEAR(to_deg(most - least), 270.0, 2.0);
}

TEST(TurntableMotion, HasAnImuThatFeelsTheBumpAndTheVibration) {
  TurntableOptions options;
  options.swing_rad = 0.0;
  options.vibration = {1e-4, 10.0};
  options.bumps = {{1, 1.0, 5e-3}};
  const TurntableMotion motion = motion_of(13, options);
  const ImuModel imu(motion, SE3{}, ImuErrors{});
  double trembling = 0.0;
  for (int i = 0; i < 100; ++i) {
    trembling = std::max(trembling, imu.turn_rate(motion.stop_start_s(1) + 0.5 + 1e-3 * i).norm());
  }
  EXPECT_NEAR(1e-4 * 2.0 * pi * 10.0, trembling, 1e-4);
  // The peak of the quintic's slope is 15/8.
  const double peak = imu.turn_rate(motion.stop_start_s(1) + 1.0 + 0.5 * TurntableMotion::bump_s).norm();
  EXPECT_NEAR(1.875 * 5e-3 / TurntableMotion::bump_s, peak, 0.01);
}

TEST(ImuErrors, StayInTheRangeOfACheapGyro) {
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    Random random(seed);
    const ImuErrors errors = ImuErrors::draw(random);
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_GE(to_deg(std::abs(errors.gyro_bias_rad_s[axis])), 0.1);
      EXPECT_LE(to_deg(std::abs(errors.gyro_bias_rad_s[axis])), 0.3);
    }
  }
}

}  // namespace
}  // namespace rigcal::sim
