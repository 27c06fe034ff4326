#include "core/quality/stop_advice.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

namespace rigcal {
namespace {

// Two LiDARs that look 70 degrees wide, the second one to the left, on a table in a round of upright walls.
struct Round {
  RigState state;
  std::vector<char> stop_known;
  std::vector<char> lidar_known{1, 1};
  std::vector<SeenSurface> surfaces;
  std::vector<Matrix6d> covariances{2, Matrix6d::Zero()};
  bool has_floor = true;

  explicit Round(const std::vector<double>& stops_deg, bool floor = true) : has_floor(floor) {
    state.T_base_sensor = {SE3{}, {exp_so3(to_rad(90.0) * Vector3d::UnitZ()), Vector3d(0.0, 0.1, 0.0)}};
    for (const double angle : stops_deg) add_stop(to_rad(angle));
  }

  void add_stop(double angle) {
    state.T_G_base.push_back(TurningAxis{}.turn(angle));
    stop_known.push_back(1);
    const auto stop = static_cast<int>(stop_known.size()) - 1;
    for (int lidar = 0; lidar < 2; ++lidar) {
      const SE3 T = state.T_G_sensor(stop, lidar).inverse();
      for (int k = 0; k < 72; ++k) {
        const double azimuth = to_rad(5.0 * k);
        const Vector3d out(std::cos(azimuth), std::sin(azimuth), 0.0);
        // Walls whose normals lean a little this way and that, so that every direction is held.
        const Vector3d lean =
            0.5 * Vector3d(0.0, 0.0, k % 3 - 1.0) + 0.4 * (k % 2 - 0.5) * Vector3d::UnitZ().cross(out);
        see(T * (6.0 * out), T.R * (-out + (has_floor ? lean : Vector3d::Zero())).normalized(), lidar, stop);
        if (has_floor) see(T * (4.0 * out - 1.5 * Vector3d::UnitZ()), T.R * Vector3d::UnitZ(), lidar, stop);
      }
    }
  }

  void see(const Vector3d& p, const Vector3d& n, int lidar, int stop) {
    if (std::abs(std::atan2(p.y(), p.x())) < to_rad(35.0)) surfaces.push_back({lidar, stop, p, n, 1e-6});
  }

  [[nodiscard]] std::optional<StopAdvice> advise() const {
    return advise_stop({state, stop_known, lidar_known, 0, surfaces, covariances, Requirement{}, TurningAxis{}});
  }
};

TEST(StopAdvice, TurnsTheBaseToWhatTheOtherLidarSaw) {
  const auto advice = Round({0.0}).advise();
  ASSERT_TRUE(advice);
  EXPECT_EQ(advice->now.lidar, 1);
  ASSERT_EQ(advice->turns.size(), 23U);
  const double best = to_deg(advice->turns[advice->best_turn].angle_rad);
  // To the left the base looks where the other one did; to the right the other way round.
  EXPECT_TRUE(std::abs(best - 90.0) <= 46.0 || std::abs(best - 270.0) <= 46.0) << best;
  EXPECT_GT(advice->turns[11].after.of_goal, 2.0 * advice->turns[advice->best_turn].after.of_goal);
  EXPECT_LT(advice->turns[advice->best_turn].after.of_goal, 0.2 * advice->now.of_goal);
}

TEST(StopAdvice, NeverPromisesMoreThanItHas) {
  Round round({0.0, 90.0});
  const auto before = round.advise();
  ASSERT_TRUE(before);
  for (const TurnCandidate& turn : before->turns) EXPECT_LE(turn.after.of_goal, 1.0001 * before->now.of_goal);
  // What was foretold is about what comes.
  const double foretold = before->turns[before->best_turn].after.of_goal / before->now.of_goal;
  round.add_stop(to_rad(90.0) + before->turns[before->best_turn].angle_rad);
  const auto after = round.advise();
  ASSERT_TRUE(after);
  const double came = after->now.of_goal / before->now.of_goal;
  EXPECT_LT(came, 1.0);
  EXPECT_NEAR(came, foretold, 0.3);
}

TEST(StopAdvice, ScalesTheCovariancesThatItIsGiven) {
  Round round({0.0, 90.0});
  round.covariances[1] = 1e-4 * Matrix6d::Identity();
  const auto advice = round.advise();
  ASSERT_TRUE(advice);
  EXPECT_NEAR(advice->now.translation_m, translation_bound(round.covariances[1]), 1e-9);
  EXPECT_NEAR(advice->now.rotation_rad, rotation_bound(round.covariances[1]), 1e-9);
}

TEST(StopAdvice, WantsALeaningSurfaceWhereOnlyUprightWallsAre) {
  const auto advice = Round({0.0, 60.0, 120.0, 180.0, 240.0, 300.0}, false).advise();
  ASSERT_TRUE(advice);
  ASSERT_TRUE(advice->surface);
  EXPECT_GT(std::abs(advice->surface->normal.z()), 0.4);
  EXPECT_LT(advice->surface->after.of_goal, 0.5 * advice->now.of_goal);
  EXPECT_THAT(advice_text(*advice, {"base", "left"}), testing::HasSubstr("left is the least sure"));
  EXPECT_THAT(advice_text(*advice, {"base", "left"}), testing::HasSubstr("a flat surface of a square metre"));
}

TEST(StopAdvice, FindsNoHelpInTurnsThatShowNothingSeenBefore) {
  const auto advice = Round({0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0}).advise();
  ASSERT_TRUE(advice);
  EXPECT_NEAR(advice->turns[11].after.of_goal, advice->now.of_goal, 1e-6 * advice->now.of_goal);
  EXPECT_LT(advice->turns[advice->best_turn].after.of_goal, 0.9 * advice->now.of_goal);
}

TEST(StopAdvice, SaysNothingWithoutASecondLidar) {
  Round round({0.0});
  round.lidar_known[1] = 0;
  EXPECT_FALSE(round.advise());
}

}  // namespace
}  // namespace rigcal
