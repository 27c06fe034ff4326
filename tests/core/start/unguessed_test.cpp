#include "core/start/unguessed.h"

#include <gtest/gtest.h>

#include "core/base/parallel.h"
#include "core/start/panorama_match.h"
#include "tests/core/start/thrown_rig.h"
#include "tests/support/se3_matchers.h"

namespace rigcal {
namespace {

Start found(const ThrownRig& rig) {
  SilentReporter reporter;
  const auto start = find_start(rig.input, rig.surfels, RunContext{reporter});
  EXPECT_TRUE(start.has_value());
  return *start;
}

void expect_all_found(const ThrownRig& rig, const Start& start) {
  for (std::size_t i = 1; i < rig.truth.T_base_sensor.size(); ++i) {
    EXPECT_TRUE(start.lidar_known[i]) << i;
    EXPECT_THAT(start.state.T_base_sensor[i], SE3Near(rig.truth.T_base_sensor[i], 0.5, 60.0)) << "lidar " << i;
    EXPECT_LT(start.matches[i].runner_up_score, 0.8 * start.matches[i].score) << i;
  }
}

TEST(PlaceWithoutGuess, FindsLidarsMountedAnyWayWithAGyro) {
  ThrownRig rig("courtyard", 3, 14);
  rig.give_gyro();
  expect_all_found(rig, found(rig));
}

TEST(PlaceWithoutGuess, FindsThemWithTurnsOfWhichOnlyTheSizeIsKnown) {
  ThrownRig rig("courtyard", 3, 14);
  rig.input.turned_rad.emplace_back();
  for (const Vector3d& step : rig.truth.step_rotations) rig.input.turned_rad.emplace_back(step.norm());
  expect_all_found(rig, found(rig));
}

TEST(PlaceWithoutGuess, FindsThemWithoutGyroTableAnglesAndAxis) {
  const ThrownRig rig("courtyard", 9, 16);
  expect_all_found(rig, found(rig));
}

TEST(PlaceWithoutGuess, FindsUnitsInTheWrongOrderInEachOthersPlace) {
  ThrownRig rig("courtyard", 3, 14);
  rig.give_gyro();
  for (std::size_t i = 1; i < 4; ++i) rig.input.guess_T_base_sensor[i] = rig.truth.T_base_sensor[i % 3 + 1];
  expect_all_found(rig, found(rig));
}

// A square room, the same from all four sides, with the table in its very middle.
sim::Scene symmetric_room() {
  sim::Scene scene;
  scene.materials.push_back({});
  const auto add = [&](const Vector3d& center, const Vector3d& u, const Vector3d& v) {
    scene.flats.push_back({center, u, v, false, 0});
  };
  const Vector3d up(0.0, 0.0, 1.5);
  for (const double side : {-4.0, 4.0}) {
    add({side, 0.0, 1.5}, {0.0, 4.0, 0.0}, up);
    add({0.0, side, 1.5}, {4.0, 0.0, 0.0}, up);
  }
  for (const double height : {0.0, 3.0}) add({0.0, 0.0, height}, {4.0, 0.0, 0.0}, {0.0, 4.0, 0.0});
  scene.T_scene_table.t = Vector3d(0.0, 0.0, 1.4);
  return scene;
}

TEST(PlaceWithoutGuess, TellsThatASymmetricRoomFitsInOtherWaysToo) {
  sim::TurntableOptions upright;
  upright.axis_tilt_deg = 0.0;
  ThrownRig rig(symmetric_room(), 2, 16, upright);
  rig.give_gyro();
  const Start start = found(rig);
  for (std::size_t i = 1; i < 4; ++i) {
    EXPECT_TRUE(start.lidar_known[i]) << i;
    EXPECT_GT(start.matches[i].runner_up_score, 0.8 * start.matches[i].score) << i;
  }
}

TEST(PlaceWithoutGuess, LeavesOutALidarThatSawNothing) {
  ThrownRig rig("courtyard", 3, 14);
  for (PatchSurfels& p : rig.surfels) {
    if (p.lidar == 2) p.surfels.clear();
  }
  const Start start = found(rig);
  EXPECT_TRUE(start.lidar_known[1]);
  EXPECT_FALSE(start.lidar_known[2]);
  EXPECT_TRUE(start.lidar_known[3]);
}

TEST(PlaceWithoutGuess, IsTheSameToTheBitForOneAndTwoThreads) {
  const ThrownRig rig("courtyard", 9, 16);
  set_thread_count(1);
  const Start one = found(rig);
  set_thread_count(2);
  const Start two = found(rig);
  for (std::size_t i = 0; i < 4; ++i)
    EXPECT_EQ(one.state.T_base_sensor[i].matrix(), two.state.T_base_sensor[i].matrix());
}

TEST(MatchPanoramas, TriesThePlaceWhereTheOtherStands) {
  const ThrownRig rig("courtyard", 3, 14);
  const auto turn = turn_of_poses(rig.truth.T_G_base, std::vector<char>(14, 1));
  const Panorama map = make_panorama(turn->turn, rig.patches_of(0), rig.truth.T_G_base);
  // The base's own view in another frame.
  const SE3 T_map_other{exp_so3({0.5, 2.0, -1.0}), Vector3d(0.3, -0.4, 0.6)};
  const SE3 T = T_map_other.inverse();
  Panorama other = map;
  other.turn.axis = T.R * map.turn.axis;
  other.turn.foot = T * map.turn.foot;
  for (PlacedSurfel& s : other.surfels) s = {T * s.mean, T.R * s.normal, s.group};
  const std::vector<SE3> places = match_panoramas(map, other);
  ASSERT_FALSE(places.empty());
  EXPECT_THAT(places.front(), SE3Near(T_map_other, 1.5, 100.0));
}

}  // namespace
}  // namespace rigcal
