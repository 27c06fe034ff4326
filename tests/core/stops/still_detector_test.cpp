#include "core/stops/still_detector.h"

#include <gmock/gmock.h>

#include "tests/core/stops/rig_motion.h"

namespace rigcal {
namespace {

std::vector<StillStop> find(const std::vector<ImuSample>& samples, StillFigures* figures = nullptr,
                            const StopOptions& options = {}) {
  CollectingListener listener;
  StillDetector detector(options, listener);
  for (const ImuSample& sample : samples) detector.add(sample);
  detector.flush();
  if (figures != nullptr) *figures = detector.figures();
  return listener.stops;
}

// Every rest is found once, no stop reaches out of its rest, at least `kept` of what is usable of the rest stays, and
// no swing is left of more than `swings` times the limit of 0.1 mrad.
void expect_rests_found(const RigMotion& motion, const std::vector<StillStop>& stops, double kept = 0.8,
                        double swings = 1.0) {
  ASSERT_EQ(stops.size(), motion.rests().size());
  for (std::size_t i = 0; i < stops.size(); ++i) {
    const RigMotion::Rest& rest = motion.rests()[i];
    const double start_s = to_seconds(stops[i].stop.start_ns);
    const double end_s = to_seconds(stops[i].stop.end_ns);
    EXPECT_GE(start_s, rest.start_s) << "stop " << i;
    EXPECT_LE(end_s, rest.end_s) << "stop " << i;
    EXPECT_GE(end_s - start_s, kept * (rest.end_s - rest.settled_s))
        << "stop " << i << ": " << start_s << " .. " << end_s << " of " << rest.settled_s << " .. " << rest.end_s;
    EXPECT_LE(rest.swing_rad * std::exp(-(start_s - rest.start_s) / rest.decay_s), swings * 1e-4) << "stop " << i;
  }
}

RigMotion twenty_stops(Random& random, double dwell_s = 2.0) {
  RigMotion motion;
  motion.rest(dwell_s);
  for (int i = 1; i < 20; ++i) {
    const double tau_s = random.uniform(0.1, 0.5);
    const double swing_rad = random.uniform(0.5e-3, 5e-3);
    motion.turn(18.0, random.uniform(10.0, 40.0), random.uniform(60.0, 200.0), swing_rad, tau_s,
                random.uniform(2.0, 8.0));
    motion.rest(dwell_s + tau_s * std::log(swing_rad / 1e-4));
  }
  return motion;
}

struct NoiseCase {
  double noise_deg_s;
  std::uint64_t seed;
};
class TwentyStops : public testing::TestWithParam<NoiseCase> {};

TEST_P(TwentyStops, AreFoundOnceEachWithoutMotionOrSwing) {
  Random random(GetParam().seed);
  const RigMotion motion = twenty_stops(random);
  GyroModel gyro;
  gyro.noise_deg_s = GetParam().noise_deg_s;
  gyro.bias_deg_s = Vector3d(random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0));
  gyro.drift_deg_s2 = 2e-4;  // 0.012 deg/s a minute: a unit that warms up
  // In a gyro of 0.2 deg/s a swing of 0.5 mrad at 3 Hz (9 mrad/s) is hardly seen: it may stay in a stop of a hundred.
  const double swings = gyro.noise_deg_s < 0.08 ? 1.0 : 6.0;
  expect_rests_found(motion, find(read_gyro(motion, gyro, random)), 0.8, swings);
}

std::vector<NoiseCase> noise_cases() {
  std::vector<NoiseCase> cases;
  for (const double noise : {0.02, 0.05, 0.1, 0.2}) {
    for (std::uint64_t seed = 1; seed <= 10; ++seed) cases.push_back({noise, seed});
  }
  return cases;
}
INSTANTIATE_TEST_SUITE_P(StillDetector, TwentyStops, testing::ValuesIn(noise_cases()), [](const auto& test) {
  return "Noise" + std::to_string(static_cast<int>(1000 * test.param.noise_deg_s)) + "Seed" +
         std::to_string(test.param.seed);
});

TEST(StillDetector, GivesTheRotationBetweenStopsWithin005Degrees) {
  double worst_deg = 0.0;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    Random random(seed);
    const RigMotion motion = twenty_stops(random);
    GyroModel gyro;
    gyro.noise_deg_s = 0.1;
    gyro.bias_deg_s = Vector3d(0.3, -0.3, 0.3);
    gyro.drift_deg_s2 = 2e-4;
    const std::vector<StillStop> stops = find(read_gyro(motion, gyro, random));
    ASSERT_EQ(stops.size(), 20U);
    EXPECT_EQ(stops[0].R_previous_this, Matrix3d::Identity());
    for (std::size_t i = 1; i < stops.size(); ++i) {
      const Matrix3d truth = exp_so3(to_rad(18.0) * gyro.axis);
      worst_deg = std::max(worst_deg, to_deg(rotation_distance(stops[i].R_previous_this, truth)));
      EXPECT_TRUE(stops[i].rotation_known);
      // 0.5 % of 18 degrees is 0.09; noise adds little.
      EXPECT_NEAR(to_deg(stops[i].rotation_sigma_rad), 0.09, 0.04);
    }
  }
  EXPECT_LE(worst_deg, 0.05);
}

TEST(StillDetector, GivesRotationAboutTiltedAndChangingAxes) {
  RigMotion motion;
  motion.rest(2.0);
  motion.turn(90.0, 45.0, 100.0);
  motion.rest(2.0);
  motion.turn(-150.0, 45.0, 100.0);
  motion.rest(2.0);
  GyroModel gyro;
  gyro.axis = Vector3d(1.0, -2.0, 0.5).normalized();
  Random random(3);
  const std::vector<StillStop> stops = find(read_gyro(motion, gyro, random));
  ASSERT_EQ(stops.size(), 3U);
  // 0.05 deg/s of noise over 5 s is below 0.01 deg, biases over 2 s of rest add as much.
  EXPECT_LE(to_deg(rotation_distance(stops[1].R_previous_this, exp_so3(to_rad(90.0) * gyro.axis))), 0.05);
  EXPECT_LE(to_deg(rotation_distance(stops[2].R_previous_this, exp_so3(to_rad(-150.0) * gyro.axis))), 0.05);
}

TEST(StillDetector, GivesBiasAndUpDirectionOfAStop) {
  RigMotion motion;
  motion.rest(5.0);
  GyroModel gyro;
  Random random(1);
  const std::vector<StillStop> stops = find(read_gyro(motion, gyro, random));
  ASSERT_EQ(stops.size(), 1U);
  // 0.05 deg/s over 1000 samples: 0.0016 deg/s, 0.002 g over as many: 0.00006 g; four sigma.
  EXPECT_LE((to_deg(1.0) * stops[0].gyro_bias_rad_s - gyro.bias_deg_s).cwiseAbs().maxCoeff(), 0.0064);
  EXPECT_LE((stops[0].acceleration_g - gyro.axis).cwiseAbs().maxCoeff(), 0.00024);
}

TEST(StillDetector, FindsStopsOfOneSecondAndOfThirty) {
  for (const double dwell_s : {1.0, 30.0}) {
    RigMotion motion;
    motion.rest(dwell_s);
    for (int i = 0; i < 5; ++i) {
      motion.turn(18.0, 20.0, 100.0);
      motion.rest(dwell_s);
    }
    for (const double noise : {0.05, 0.2}) {
      GyroModel gyro;
      gyro.noise_deg_s = noise;
      Random random(11);
      // The margins take 0.1 s, bins of 25 ms and what hides in the noise the rest.
      expect_rests_found(motion, find(read_gyro(motion, gyro, random)), noise < 0.1 ? 0.8 : 0.7);
    }
  }
}

TEST(StillDetector, DropsRestsShorterThanTheMinimum) {
  RigMotion motion;
  motion.rest(2.0);
  motion.turn(18.0, 20.0, 100.0);
  motion.rest(0.4);
  motion.turn(18.0, 20.0, 100.0);
  motion.rest(2.0);
  Random random(1);
  const std::vector<StillStop> stops = find(read_gyro(motion, GyroModel{}, random));
  ASSERT_EQ(stops.size(), 2U);
  // The rotation goes on over the dropped rest.
  EXPECT_NEAR(to_deg(log_so3(stops[1].R_previous_this).norm()), 36.0, 0.05);
}

TEST(StillDetector, DoesNotTakeSlowCreepForStill) {
  for (const double creep_deg_s : {0.2, -0.2, 0.5}) {
    for (const double noise : {0.05, 0.2}) {
      for (std::uint64_t seed = 1; seed <= 5; ++seed) {
        RigMotion motion;
        motion.rest(2.0);
        motion.creep(creep_deg_s, 4.0);
        motion.rest(2.0);
        motion.turn(18.0, 20.0, 100.0);
        motion.rest(2.0);
        motion.creep(creep_deg_s, 1.2);
        motion.rest(2.0);
        GyroModel gyro;
        gyro.noise_deg_s = noise;
        Random random(seed);
        expect_rests_found(motion, find(read_gyro(motion, gyro, random)), 0.6);
      }
    }
  }
}

TEST(StillDetector, FindsTheStopsOfARigThatMovesFromTheFirstMomentOn) {
  RigMotion motion;
  motion.turn(30.0, 20.0, 100.0);
  for (int i = 0; i < 4; ++i) {
    motion.rest(2.0);
    motion.turn(18.0, 20.0, 100.0);
  }
  GyroModel gyro;
  Random random(1);
  expect_rests_found(motion, find(read_gyro(motion, gyro, random)));
}

TEST(StillDetector, LearnsAnewWhenTheFirstSteadyRateWasARotation) {
  RigMotion motion;
  motion.creep(0.8, 3.0);
  for (int i = 0; i < 5; ++i) {
    motion.rest(3.0);
    motion.turn(18.0, 20.0, 100.0);
  }
  GyroModel gyro;
  gyro.bias_deg_s = Vector3d(0.1, 0.1, -0.7);  // the creep looks like a smaller bias than the bias itself
  Random random(1);
  StillFigures figures;
  const std::vector<StillStop> stops = find(read_gyro(motion, gyro, random), &figures);
  EXPECT_GE(figures.bias_changes, 1);
  const auto found = [&](const RigMotion::Rest& rest) {
    return std::any_of(stops.begin(), stops.end(), [&](const StillStop& s) {
      return to_seconds(s.stop.start_ns) >= rest.start_s && to_seconds(s.stop.end_ns) <= rest.end_s;
    });
  };
  // The creep outvotes the first rest; from the second on the rests are the majority.
  for (std::size_t i = 1; i < motion.rests().size(); ++i) EXPECT_TRUE(found(motion.rests()[i])) << "rest " << i;
}

TEST(StillDetector, FindsNothingWhereTheRigNeverStands) {
  RigMotion steady;
  steady.creep(15.0, 60.0);
  RigMotion busy;
  for (int i = 0; i < 100; ++i) busy.turn(i % 2 == 0 ? 20.0 : -15.0, 40.0, 80.0);
  Random random(1);
  for (const RigMotion& motion : {steady, busy}) {
    StillFigures figures;
    EXPECT_TRUE(find(read_gyro(motion, GyroModel{}, random), &figures).empty());
    EXPECT_LT(figures.longest_still_s, 0.5);
    EXPECT_GT(figures.imu_samples, 5000U);
    EXPECT_GT(figures.gyro_noise_rad_s, 0.0);
  }
}

TEST(StillDetector, MakesOneStopOfARecordingThatStandsStillThroughout) {
  RigMotion motion;
  motion.rest(600.0);
  GyroModel gyro;
  gyro.noise_deg_s = 0.1;
  gyro.drift_deg_s2 = 5e-4;  // 0.3 deg/s in all
  Random random(1);
  StillFigures figures;
  expect_rests_found(motion, find(read_gyro(motion, gyro, random), &figures), 0.99);
  // The lowest of many estimates of 80 squares each.
  EXPECT_NEAR(to_deg(figures.gyro_noise_rad_s), 0.1, 0.02);
}

TEST(StillDetector, FindsTheSameUnderATimeShift) {
  Random random(5);
  const RigMotion motion = twenty_stops(random);
  std::vector<ImuSample> samples = read_gyro(motion, GyroModel{}, random);
  const std::vector<StillStop> stops = find(samples);
  constexpr std::int64_t shift_ns = 123'456'789'012;
  for (ImuSample& sample : samples) sample.stamp_ns += shift_ns;
  const std::vector<StillStop> shifted = find(samples);
  ASSERT_EQ(shifted.size(), stops.size());
  for (std::size_t i = 0; i < stops.size(); ++i) {
    EXPECT_EQ(shifted[i].stop.start_ns, stops[i].stop.start_ns + shift_ns);
    EXPECT_EQ(shifted[i].stop.end_ns, stops[i].stop.end_ns + shift_ns);
  }
}

TEST(StillDetector, BearsLostDoubledAndSwappedSamples) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    Random random(seed);
    const RigMotion motion = twenty_stops(random);
    GyroModel gyro;
    gyro.noise_deg_s = 0.1;
    gyro.loss = 0.05;
    std::vector<ImuSample> samples = read_gyro(motion, gyro, random);
    const std::size_t read = samples.size();
    for (std::size_t i = 3; i < samples.size(); ++i) {
      if (random.uniform() < 0.02) std::swap(samples[i], samples[i - random.below(3)]);
      if (random.uniform() < 0.01) samples.insert(samples.begin() + static_cast<std::ptrdiff_t>(i), samples[i]);
    }
    ASSERT_GT(samples.size(), read + 10);
    StillFigures figures;
    const std::vector<StillStop> stops = find(samples, &figures);
    EXPECT_LE(figures.imu_samples, read) << "those that came twice count once";
    expect_rests_found(motion, stops, 0.8, 2.0);  // a noise of 0.1 deg/s, see above
    for (std::size_t i = 1; i < stops.size(); ++i) {
      EXPECT_NEAR(to_deg(log_so3(stops[i].R_previous_this).norm()), 18.0, 0.05);
    }
  }
}

void remove(std::vector<ImuSample>& samples, double from_s, double to_s) {
  std::erase_if(samples,
                [&](const ImuSample& s) { return s.stamp_ns >= to_stamp(from_s) && s.stamp_ns < to_stamp(to_s); });
}

TEST(StillDetector, SaysThatARotationIsUnknownWhereTheUnitWasSilentOnTheWay) {
  RigMotion motion;
  motion.rest(2.0);
  motion.turn(18.0, 20.0, 100.0);  // 1.1 s
  motion.rest(2.0);
  motion.turn(18.0, 20.0, 100.0);
  motion.rest(2.0);
  Random random(1);
  for (const double gap_s : {0.1, 0.3, 1.05}) {
    std::vector<ImuSample> samples = read_gyro(motion, GyroModel{}, random);
    remove(samples, 3.1 - gap_s, 3.1);  // up to the end of the first turn
    const std::vector<StillStop> stops = find(samples);
    expect_rests_found(motion, stops, 0.7);
    ASSERT_EQ(stops.size(), 3U);
    EXPECT_FALSE(stops[1].rotation_known) << gap_s;
    EXPECT_TRUE(stops[2].rotation_known) << gap_s;
  }
}

TEST(StillDetector, BridgesAShortSilenceInAStopAndCutsAtALongOne) {
  RigMotion motion;
  motion.rest(6.0);
  Random random(1);
  std::vector<ImuSample> samples = read_gyro(motion, GyroModel{}, random);
  remove(samples, 3.0, 3.18);
  const std::vector<StillStop> one = find(samples);
  ASSERT_EQ(one.size(), 1U);
  EXPECT_TRUE(one[0].imu_gap);
  EXPECT_EQ(one[0].end, StopEnd::stream);
  remove(samples, 3.0, 4.0);
  const std::vector<StillStop> two = find(samples);
  ASSERT_EQ(two.size(), 2U);
  EXPECT_LE(to_seconds(two[0].stop.end_ns), 3.0);
  EXPECT_GE(to_seconds(two[1].stop.start_ns), 4.0);
  EXPECT_FALSE(two[1].rotation_known);
  EXPECT_EQ(two[0].end, StopEnd::silence);
  EXPECT_EQ(two[1].end, StopEnd::stream);
}

TEST(StillDetector, EndsAStopBeforeAMotionThatBeginsInASilence) {
  RigMotion motion;
  motion.rest(3.0);
  motion.turn(18.0, 20.0, 100.0);
  motion.rest(3.0);
  Random random(1);
  std::vector<ImuSample> samples = read_gyro(motion, GyroModel{}, random);
  remove(samples, 2.92, 3.1);
  const std::vector<StillStop> stops = find(samples);
  expect_rests_found(motion, stops);
  EXPECT_EQ(stops[0].end, StopEnd::motion);
}

TEST(StillDetector, IgnoresNonsenseAndOtherUnits) {
  RigMotion motion;
  motion.rest(3.0);
  Random random(1);
  std::vector<ImuSample> samples = read_gyro(motion, GyroModel{}, random);
  ImuSample bad = samples[100];
  bad.gyro_rad_s.x() = std::numeric_limits<double>::quiet_NaN();
  ImuSample far = samples[100];
  far.stamp_ns = std::numeric_limits<std::int64_t>::max();
  ImuSample other = samples[100];
  other.sensor = 7;
  other.gyro_rad_s.x() = 3.0;
  samples.insert(samples.begin() + 101, {bad, far, other});
  StillFigures figures;
  expect_rests_found(motion, find(samples, &figures));
  EXPECT_EQ(figures.imu_unusable, 2U);
  EXPECT_EQ(figures.imu_of_others, 1U);
}

TEST(StillDetector, LeavesImpossibleReadingsOutOfATurn) {
  RigMotion motion;
  motion.rest(3.0);
  motion.turn(18.0, 60.0, 100.0);
  motion.rest(3.0);
  Random random(1);
  const std::vector<ImuSample> samples = read_gyro(motion, GyroModel{}, random);
  const auto spoil_turn = [&](auto spoil) {
    std::vector<ImuSample> spoiled = samples;
    const auto turning = std::max_element(spoiled.begin(), spoiled.end(), [](const ImuSample& a, const ImuSample& b) {
      return a.gyro_rad_s.norm() < b.gyro_rad_s.norm();
    });
    spoil(*turning);
    return spoiled;
  };
  for (const double reading : {6.8e37, 1e200, -71.0}) {
    StillFigures figures;
    const auto stops = find(spoil_turn([&](ImuSample& s) { s.gyro_rad_s.y() = reading; }), &figures);
    ASSERT_EQ(stops.size(), 2U) << reading;
    EXPECT_TRUE(stops[1].rotation_known) << reading;
    EXPECT_NEAR(log_so3(stops[1].R_previous_this).norm(), to_rad(18.0), to_rad(0.3)) << reading;
    EXPECT_EQ(figures.imu_unusable, 1U) << reading;
  }
  StillFigures figures;
  EXPECT_EQ(find(spoil_turn([](ImuSample& s) { s.acceleration_g.z() = 6.8e37; }), &figures).size(), 2U);
  EXPECT_EQ(figures.imu_unusable, 1U);
}

TEST(StillDetector, DoesNotKnowATurnThatItIsNotSureOf) {
  RigMotion motion;
  motion.rest(3.0);
  motion.turn(90.0, 60.0, 100.0);
  motion.rest(3.0);
  Random random(1);
  const std::vector<ImuSample> samples = read_gyro(motion, GyroModel{}, random);
  StopOptions options;
  for (const double scale_sigma : {0.2, std::numeric_limits<double>::quiet_NaN()}) {
    options.gyro_scale_sigma = scale_sigma;
    const auto stops = find(samples, nullptr, options);
    ASSERT_EQ(stops.size(), 2U);
    EXPECT_FALSE(stops[1].rotation_known) << scale_sigma;
  }
}

TEST(StillDetector, HasNothingToSayOfAnEmptyStream) {
  StillFigures figures;
  EXPECT_TRUE(find({}, &figures).empty());
  EXPECT_EQ(figures.imu_samples, 0U);
}

}  // namespace
}  // namespace rigcal
