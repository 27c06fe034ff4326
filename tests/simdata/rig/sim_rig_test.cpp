#include "simdata/rig/sim_rig.h"

#include <gtest/gtest.h>

#include <cmath>

#include "simdata/rig/light_rig.h"
#include "simdata/scene/scene_file.h"

namespace rigcal::sim {
namespace {

SimulatedRig rig_of(std::uint64_t seed, const UnitErrorOptions& errors) {
  auto rig = make_simulated_rig(nominal_rig(), {}, {}, {}, seed, errors);
  EXPECT_TRUE(rig.has_value());
  return *std::move(rig);
}

TEST(SimulatedRig, DrawsABiasOfItsOwnForEachUnitAndLeavesTheRestOfTheRunAlone) {
  UnitErrorOptions errors;
  errors.range_bias_sigma_m = 0.01;
  double squares = 0.0;
  int units = 0;
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    const SimulatedRig biased = rig_of(seed, errors);
    const SimulatedRig plain = rig_of(seed, {});
    EXPECT_NE(biased.lidars[0].noise.range_bias, biased.lidars[1].noise.range_bias);
    for (std::size_t i = 0; i < biased.lidars.size(); ++i) {
      squares += biased.lidars[i].noise.range_bias * biased.lidars[i].noise.range_bias;
      ++units;
      EXPECT_EQ(0.0, plain.lidars[i].noise.range_bias);
      EXPECT_EQ(plain.T_base_sensor[i].t, biased.T_base_sensor[i].t);
      EXPECT_EQ(plain.lidars[i].scanner.direction(1000), biased.lidars[i].scanner.direction(1000));
    }
  }
  // Five sigma of the standard deviation of 400.
  EXPECT_NEAR(0.01, std::sqrt(squares / units), 5.0 * 0.01 / std::sqrt(800.0));
}

struct Ground {
  double range_change_m = 0.0;  // in the mean
  double darkness = 0.0;        // of it, as the sensor sees it
  double rms_height_m = 0.0;
};

// What a MID-40 measures in an empty field, of its flat ground.
Ground ground_of(const UnitErrorOptions& errors, std::uint64_t seed) {
  Scene scene;
  scene.materials = {{"grass", 50.0}};
  scene.has_ground = true;
  scene.T_scene_table.t = Vector3d(0.0, 0.0, 1.3);
  LightRigOptions options;
  options.seed = seed;
  options.turntable.stops = 1;
  options.shots_per_patch = 40'000;
  options.unit_errors = errors;
  options.unit_errors.footprint_share = 0.0;
  const auto light = make_light_rig(scene, options);
  EXPECT_TRUE(light.has_value());
  const auto simulated = make_simulated_rig(light->rig, scene.T_scene_table, options.turntable, options.mount_error,
                                            seed, options.unit_errors);
  const Patch& patch = light->patches[1];
  const SE3 T_scene_sensor = simulated->motion.T_scene_G() * light->T_base_sensor[1];
  Ground sum;
  std::size_t count = 0;
  for (const Point& point : patch.points) {
    const Vector3d p(point.x, point.y, point.z);
    const Vector3d ray = T_scene_sensor.R * p.normalized();
    const double range = -T_scene_sensor.t.z() / ray.z();  // of the ground in the direction that the sensor says
    if (!(range > 0.0 && range < 10.0)) continue;
    sum.range_change_m += p.norm() - range;
    sum.darkness += 1.0 - point.reflectivity / 100.0;
    const double height = (T_scene_sensor * p).z();
    sum.rms_height_m += height * height;
    ++count;
  }
  EXPECT_GT(count, 300U);
  const auto n = static_cast<double>(count);
  return {sum.range_change_m / n, sum.darkness / n, std::sqrt(sum.rms_height_m / n)};
}

TEST(SimulatedRig, MeasuresWithTheBiasOfTheUnitAndWithItsWobble) {
  UnitErrorOptions errors;
  errors.range_bias_sigma_m = 0.05;
  errors.dark_bias_m = 0.08;
  const double bias = rig_of(3, errors).lidars[1].noise.range_bias;
  const Ground plain = ground_of({}, 3);
  const Ground biased = ground_of(errors, 3);
  // Half reflectivity, and darker where it is met aslant: more than half of the dark bias.
  EXPECT_GT(biased.darkness, 0.55);
  EXPECT_LT(biased.darkness, 0.8);
  // The same rays with other noise of 18 mm, 300 of them at least.
  EXPECT_NEAR(bias + 0.08 * biased.darkness, biased.range_change_m - plain.range_change_m,
              5.0 * 0.018 * std::sqrt(2.0 / 300.0));

  UnitErrorOptions wobbling;
  wobbling.wobble_rad = to_rad(0.3);
  const Ground wobbly = ground_of(wobbling, 3);
  // 0.3 degrees at up to 10 m are 52 mm across the ray, in one of two directions at a time: 20 mm and more in height.
  EXPECT_GT(wobbly.rms_height_m, plain.rms_height_m + 0.01);
  EXPECT_LT(wobbly.rms_height_m, 0.06);
}

}  // namespace
}  // namespace rigcal::sim
