#include "core/start/hand_eye.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/start/drive.h"
#include "tests/core/start/thrown_rig.h"
#include "tests/support/se3_matchers.h"

namespace rigcal {
namespace {

sim::TurntableOptions figure8(double drive_m) {
  sim::TurntableOptions options;
  options.drive_m = drive_m;
  sim::let_wander(0.1, 1.0, options);
  return options;
}

ThrownRig driven(const std::string& scene, std::uint64_t seed, double drive_m) {
  return {*sim::load_scene(scene), seed, 28, figure8(drive_m)};
}

TEST(MainAxis, IsTheOneThatPosesTurnAbout) {
  const Vector3d axis = Vector3d(0.2, -0.5, 0.8).normalized();
  std::vector<SE3> poses;
  for (int j = 0; j < 8; ++j) poses.push_back({exp_so3((0.4 * j - 1.0) * axis), Vector3d(j, 0.0, 1.0)});
  EXPECT_GT(std::abs(main_axis(poses).dot(axis)), 1.0 - 1e-9);
}

TEST(FindMountings, FindsWhereALidarSitsButForItsHeightFromItsOwnViewOfADrive) {
  const ThrownRig rig = driven("courtyard", 3, 3.0);
  const Vector3d axis = main_axis(rig.truth.T_G_base);
  for (std::size_t i = 1; i < 4; ++i) {
    const auto found = find_mountings(rig.patches_of(static_cast<int>(i)), rig.truth.T_G_base);
    ASSERT_FALSE(found.empty()) << i;
    const SE3& truth = rig.truth.T_base_sensor[i];
    EXPECT_LT(to_deg(rotation_distance(found[0].T_base_sensor.R, truth.R)), 1.0) << i;
    Vector3d off = found[0].T_base_sensor.t - truth.t;
    off -= off.dot(axis) * axis;
    EXPECT_LT(off.norm(), 0.1) << i;
  }
}

TEST(FindMountings, HasNothingToSayOfOnePatch) {
  const ThrownRig rig = driven("room", 3, 1.2);
  EXPECT_TRUE(find_mountings({rig.patches_of(1).front()}, rig.truth.T_G_base).empty());
  EXPECT_TRUE(find_mountings({}, rig.truth.T_G_base).empty());
}

TEST(MountingsOnMap, FindTheHeightThatTheMapTells) {
  const ThrownRig rig = driven("courtyard", 3, 3.0);
  std::vector<PlacedSurfel> map;
  MovingSurfels moving{rig.truth.T_G_base, {}};
  for (const PatchSurfels& p : rig.patches_of(1)) {
    const SE3 T = rig.truth.T_G_base[static_cast<std::size_t>(p.stop)] * rig.truth.T_base_sensor[1];
    for (const Surfel& s : p.surfels) {
      map.push_back({T * s.mean, T.R * s.normal, 0});
      moving.items.push_back({p.stop, s.mean, s.normal});
    }
  }
  const Vector3d axis = main_axis(rig.truth.T_G_base);
  SE3 raised = rig.truth.T_base_sensor[1];
  raised.t += 0.9 * axis;
  const auto places = mountings_on_map(SurfelIndex(map, 0.5), moving, {{raised, 1.0}}, axis);
  ASSERT_FALSE(places.empty());
  EXPECT_THAT(places.front(), SE3Near(rig.truth.T_base_sensor[1], 0.1, 100.0));
}

// The base looks ahead, as on a vehicle.
LightRun vehicle(std::uint64_t seed) {
  sim::LightRigOptions options;
  options.seed = seed;
  options.turntable = figure8(3.0);
  options.turntable.stops = 28;
  options.shots_per_patch = 20000;
  auto light = sim::make_light_rig(*sim::load_scene("courtyard"), options);
  EXPECT_TRUE(light.has_value());
  return LightRun(*std::move(light));
}

TEST(PosesOfDrive, FollowTheBaseAlongItsWay) {
  for (const std::uint64_t seed : {1, 2}) {
    const LightRun run = vehicle(seed);
    std::vector<Matrix3d> R;
    for (const SE3& T : run.truth.T_G_base) R.push_back(T.R);
    std::vector<PatchSurfels> of_base;
    for (const PatchSurfels& p : run.surfels) {
      if (p.lidar == 0) of_base.push_back(p);
    }
    const std::vector<SE3> poses = poses_of_drive(of_base, R);
    ASSERT_EQ(poses.size(), 28U);
    for (std::size_t j = 0; j < poses.size(); ++j) {
      EXPECT_EQ(poses[j].R, R[j]);
      EXPECT_LT((poses[j].t - run.truth.T_G_base[j].t).norm(), 0.25) << "seed " << seed << " stop " << j;
    }
  }
}

TEST(PosesOfDrive, StayWhereNothingIsSeen) {
  const std::vector<Matrix3d> R{Matrix3d::Identity(), exp_so3(Vector3d(0.0, 0.0, 1.0))};
  const std::vector<SE3> poses = poses_of_drive({}, R);
  ASSERT_EQ(poses.size(), 2U);
  EXPECT_THAT(poses[1], SE3Near(SE3{R[1], Vector3d::Zero()}, 0.0, 0.0));
}

TEST(FindStart, FindsLidarsWithoutAGuessOnAVehicleThatDrives) {
  LightRun run = vehicle(1);
  run.give_gyro();
  SilentReporter reporter;
  const auto start = find_start(run.input, run.surfels, RunContext{reporter});
  ASSERT_TRUE(start);
  for (std::size_t i = 1; i < 4; ++i) {
    EXPECT_TRUE(start->lidar_known[i]) << i;
    EXPECT_THAT(start->state.T_base_sensor[i], SE3Near(run.truth.T_base_sensor[i], 0.5, 60.0)) << "lidar " << i;
  }
}

double farthest_off(const std::vector<SE3>& poses, const std::vector<SE3>& truth) {
  double worst = 0.0;
  for (std::size_t j = 0; j < truth.size(); ++j) worst = std::max(worst, (poses[j].t - truth[j].t).norm());
  return worst;
}

// A base that looks anywhere sees one wall and the ceiling from some stops, and slides along both.
TEST(FindStart, PlacesTheStopsOfADriveByWhatAllLidarsSaw) {
  ThrownRig rig = driven("room", 3, 1.2);
  rig.give_gyro();
  std::vector<Matrix3d> R;
  for (const SE3& T : rig.truth.T_G_base) R.push_back(T.R);
  EXPECT_GT(farthest_off(poses_of_drive(rig.patches_of(0), R), rig.truth.T_G_base), 0.5);
  SilentReporter reporter;
  const auto start = find_start(rig.input, rig.surfels, RunContext{reporter});
  ASSERT_TRUE(start);
  EXPECT_LT(farthest_off(start->state.T_G_base, rig.truth.T_G_base), 0.1);
}

}  // namespace
}  // namespace rigcal
