#include "apps/experiment/targetless/icp.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>

#include "core/base/random.h"

namespace rigcal::targetless {
namespace {

// A room of 8 by 6 by 3 m, seen from within by rays in all directions: exact points.
Patch seen_in_room(int lidar, int stop, const SE3& T_G_sensor, Random& random) {
  const Vector3d low(-4.0, -3.0, -1.0);
  const Vector3d high(4.0, 3.0, 2.0);
  Patch patch{lidar, stop, {}};
  for (int k = 0; k < 6000; ++k) {
    Vector3d ray;
    for (int axis = 0; axis < 3; ++axis) ray[axis] = random.normal();
    double range = 1e9;
    for (int axis = 0; axis < 3; ++axis) {
      const double wall = ray[axis] > 0.0 ? high[axis] : low[axis];
      range = std::min(range, (wall - T_G_sensor.t[axis]) / ray[axis]);
    }
    const Vector3d p = T_G_sensor.inverse() * (T_G_sensor.t + range * ray);
    Point point{};
    point.x = static_cast<float>(p.x());
    point.y = static_cast<float>(p.y());
    point.z = static_cast<float>(p.z());
    patch.points.push_back(point);
  }
  return patch;
}

struct Room {
  RigState truth;
  std::vector<Patch> patches;

  Room() {
    truth.T_G_base = {SE3{}, SE3{exp_so3({0.0, 0.0, 0.8}), {0.3, 0.1, 0.0}},
                      SE3{exp_so3({0.05, 0.0, 1.7}), {0.1, 0.4, 0.05}}};
    truth.T_base_sensor = {SE3{}, SE3{exp_so3({0.1, -0.3, 2.0}), {-0.1, 0.2, 0.1}}};
    Random random(1);
    for (int stop = 0; stop < 3; ++stop) {
      for (int lidar = 0; lidar < 2; ++lidar)
        patches.push_back(seen_in_room(lidar, stop, truth.T_G_sensor(stop, lidar), random));
    }
  }
};

TEST(RunIcp, ComesBackFromWrongPosesAndExtrinsics) {
  const Room room;
  PairwiseIcp icp(room.patches, IcpOptions{});
  RigState state = room.truth;
  for (std::size_t j = 1; j < 3; ++j)
    state.T_G_base[j] = state.T_G_base[j] * SE3{exp_so3({0.01, -0.01, 0.02}), {0.03, 0.0, -0.02}};
  state.T_base_sensor[1] = state.T_base_sensor[1] * SE3{exp_so3({0.08, 0.06, -0.1}), {0.15, -0.1, 0.1}};
  SilentReporter silent;
  IcpRunOptions options;
  int told = 0;
  options.after_iteration = [&](const RigState&) { ++told; };
  const IcpRun run = run_icp(icp, options, {silent}, state);
  EXPECT_TRUE(run.settled);
  EXPECT_LT(run.iterations, options.iterations);
  EXPECT_EQ(told, run.iterations);
  EXPECT_LT((state.T_base_sensor[1].t - room.truth.T_base_sensor[1].t).norm(), 0.002);
  EXPECT_LT(rotation_distance(state.T_base_sensor[1].R, room.truth.T_base_sensor[1].R), 0.001);
  for (std::size_t j = 0; j < 3; ++j) EXPECT_LT((state.T_G_base[j].t - room.truth.T_G_base[j].t).norm(), 0.002) << j;
}

// One wall from x = from to x = to, seen column by column from there on.
Patch wall_between(int lidar, double from, double to) {
  Patch patch{lidar, 0, {}};
  const double way = to < from ? -0.1 : 0.1;
  for (int column = 0; column < static_cast<int>(std::lround(std::abs(to - from) / 0.1)); ++column) {
    for (int row = 0; row < 20; ++row) {
      Point point{};
      point.x = static_cast<float>(from + (column + 0.5) * way);
      point.y = 3.05F;
      point.z = static_cast<float>(0.1 * (row - 10) + 0.05);
      patch.points.push_back(point);
    }
  }
  return patch;
}

// The first points of a patch may all lie where the other patch saw nothing.
TEST(PairwiseIcp, AsksPointsFromAllOverAPatchFirst) {
  const std::vector<Patch> patches{wall_between(0, -5.0, 5.0), wall_between(1, 0.0, 5.0)};
  const RigState state{{SE3{}}, {SE3{}, SE3{}}};
  IcpOptions options;
  options.queries = std::numeric_limits<std::size_t>::max();
  PairwiseIcp icp(patches, options);
  // Half of the first one's 2000 points and all 1000 of the second, each once.
  EXPECT_EQ(icp.match(state, 0.01), 2000U);
}

TEST(PairwiseIcp, MatchesOnlyWhatIsWithinReach) {
  const Room room;
  PairwiseIcp icp(room.patches, IcpOptions{});
  RigState away = room.truth;
  away.T_base_sensor[1].t += Vector3d(0.0, 0.0, 50.0);
  const std::size_t all = icp.match(room.truth, 0.5);
  const std::size_t apart = icp.match(away, 0.5);
  // Each with its own patches only.
  EXPECT_GT(all, 2 * apart - 1);
  EXPECT_GT(apart, 0U);
  EXPECT_EQ(icp.match(away, 0.5, 0) + icp.match(away, 0.5, 1), apart);
}

}  // namespace
}  // namespace rigcal::targetless
