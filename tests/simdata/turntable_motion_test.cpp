#include "simdata/turntable_motion.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "simdata/imu_model.h"

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
