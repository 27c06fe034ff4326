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

// Ranges of the MID-40s in an empty field, on its flat ground.
double mean_range_change(const UnitErrorOptions& errors, std::uint64_t seed, double& rms_height) {
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
  double change = 0.0;
  double heights = 0.0;
  std::size_t count = 0;
  for (const Point& point : patch.points) {
    const Vector3d p(point.x, point.y, point.z);
    const Vector3d ray = T_scene_sensor.R * p.normalized();
    const double range = -T_scene_sensor.t.z() / ray.z();  // of the ground in the direction that the sensor says
    if (!(range > 0.0 && range < 10.0)) continue;
    change += p.norm() - range;
    const double height = (T_scene_sensor * p).z();
    heights += height * height;
    ++count;
  }
  EXPECT_GT(count, 300U);
  rms_height = std::sqrt(heights / static_cast<double>(count));
  return change / static_cast<double>(count);
}

TEST(SimulatedRig, MeasuresWithTheBiasOfTheUnitAndWithItsWobble) {
  UnitErrorOptions errors;
  errors.range_bias_sigma_m = 0.05;
  errors.dark_bias_m = 0.08;
  double height = 0.0;
  const double bias = rig_of(3, errors).lidars[1].noise.range_bias;
  const double plain = mean_range_change({}, 3, height);
  const double plain_height = height;
  // The same rays with other noise of 18 mm, 300 of them at least; half reflectivity: half of the dark bias.
  EXPECT_NEAR(bias + 0.04, mean_range_change(errors, 3, height) - plain, 5.0 * 0.018 * std::sqrt(2.0 / 300.0));

  UnitErrorOptions wobbling;
  wobbling.wobble_rad = to_rad(0.3);
  mean_range_change(wobbling, 3, height);
  // 0.3 degrees at up to 10 m are 52 mm across the ray, in one of two directions at a time: 20 mm and more in height.
  EXPECT_GT(height, plain_height + 0.01);
  EXPECT_LT(height, 0.06);
}

}  // namespace
}  // namespace rigcal::sim
