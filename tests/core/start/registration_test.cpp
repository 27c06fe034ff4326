#include "core/start/registration.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/base/parallel.h"
#include "tests/support/make_cells.h"
#include "tests/support/make_planes.h"
#include "tests/support/se3_matchers.h"

namespace rigcal {
namespace {

constexpr int stops = 6;

// The base's map of a room at the true poses, and the other LiDAR's surfels.
struct Room {
  RigState truth = turning_rig(stops, Vector3d(0.25, 0.1, 0.0));
  std::vector<PlacedSurfel> map;
  MovingSurfels moving;

  explicit Room(std::uint64_t seed) {
    Random random(seed);
    const auto patches = make_patches(make_room(), truth, View{80.0, to_rad(50.0), {0.02, 0.0, 0.0005}}, random);
    moving.places = truth.T_G_base;
    for (const PatchSurfels& p : extract_surfels(patches, SurfelOptions{})) {
      const SE3 T = truth.T_G_sensor(p.stop, p.lidar);
      for (const Surfel& s : p.surfels) {
        if (p.lidar == 0)
          map.push_back({T * s.mean, T.R * s.normal, p.stop});
        else
          moving.items.push_back({p.stop, s.mean, s.normal});
      }
    }
  }
  [[nodiscard]] SurfelIndex coarse() const { return {without_repetitions(map, 1.0), 1.0}; }
  [[nodiscard]] SurfelIndex fine() const { return {without_repetitions(map, 0.25), 0.5}; }
};

SE3 off_by(const SE3& T, double rotation_deg, double translation_m, Random& random) {
  const SE3 direction = random_pose(random, 1.0, 1.0);
  return {T.R * exp_so3(to_rad(rotation_deg) * log_so3(direction.R).normalized()),
          T.t + translation_m * direction.t.normalized()};
}

TEST(Registration, FindsTheExtrinsicFromTenDegreesAndTwentyCentimetres) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const Room room(seed);
    Random random(100 + seed);
    const SE3 guess = off_by(room.truth.T_base_sensor[1], 10.0, 0.2, random);
    const RegistrationResult result = register_surfels(room.coarse(), room.fine(), room.moving, guess);
    // Some thousand surfels, each a few millimetres off: 1 cm and 0.2 degrees are the tolerance of the last step.
    EXPECT_THAT(result.X, SE3Near(room.truth.T_base_sensor[1], 0.2, 10.0)) << "seed " << seed;
    EXPECT_GT(result.score, 0.8);
    EXPECT_LT(result.runner_up_score, 0.8 * result.score);
  }
}

TEST(Registration, IsTheSameToTheBitForOneAndTwoThreads) {
  const Room room(7);
  Random random(8);
  const SE3 guess = off_by(room.truth.T_base_sensor[1], 5.0, 0.1, random);
  set_thread_count(1);
  const RegistrationResult one = register_surfels(room.coarse(), room.fine(), room.moving, guess);
  set_thread_count(2);
  const RegistrationResult two = register_surfels(room.coarse(), room.fine(), room.moving, guess);
  EXPECT_EQ(one.X.R, two.X.R);
  EXPECT_EQ(one.X.t, two.X.t);
  EXPECT_EQ(one.score, two.score);
  EXPECT_EQ(one.runner_up_score, two.runner_up_score);
}

TEST(Registration, ScoresLowWhereTheSurfacesAreOthers) {
  const Room room(9);
  MovingSurfels elsewhere = room.moving;
  Random random(10);
  for (auto& item : elsewhere.items) {
    item.mean = random_pose(random, 0.0, 2.0).t;
    item.normal = -item.mean.normalized();
  }
  const RegistrationResult result = register_surfels(room.coarse(), room.fine(), elsewhere, SE3{});
  EXPECT_LT(result.score, 0.15);
}

TEST(Registration, OfNothingScoresNothing) {
  const Room room(11);
  MovingSurfels nothing = room.moving;
  nothing.items.clear();
  EXPECT_EQ(0.0, register_surfels(room.coarse(), room.fine(), nothing, SE3{}).score);
  const SurfelIndex empty({}, 1.0);
  EXPECT_EQ(0.0, register_surfels(empty, empty, room.moving, SE3{}).score);
}

TEST(MatchScore, IsTheShareOfSurfelsThatMeetOneWithinTheTolerances) {
  const SurfelIndex index({{Vector3d(1, 0, 0), Vector3d::UnitZ(), 0}, {Vector3d(5, 0, 0), Vector3d::UnitX(), 0}}, 1.0);
  const SE3 up{Matrix3d::Identity(), Vector3d(0, 0, 2)};
  MovingSurfels moving{{SE3{}, up.inverse()}, {}};
  moving.items.push_back({0, Vector3d(1.1, 0.1, 0.05), Vector3d::UnitZ()});   // near, on the plane
  moving.items.push_back({0, Vector3d(1.1, 0.1, 0.15), Vector3d::UnitZ()});   // too far off the plane
  moving.items.push_back({0, Vector3d(1.1, 0.1, 0.05), -Vector3d::UnitZ()});  // faces the other way
  moving.items.push_back({1, Vector3d(5.05, 0.0, 2.1), Vector3d::UnitX()});   // near, by its place
  EXPECT_EQ(0.5, match_score(index, moving, SE3{}, 0.9, 0.1));
  EXPECT_EQ(0.0, match_score(index, moving, up, 0.9, 0.1));
}

TEST(BalancedScore, CountsEachDirectionTheSameHoweverManySurfelsFaceIt) {
  std::vector<PlacedSurfel> walls;
  MovingSurfels moving{{SE3{}}, {}};
  for (int k = 0; k < 90; ++k) {
    const Vector3d mean(3.0 * k, 0, 0);
    const Vector3d normal = Vector3d::Unit(k < 60 ? 0 : k < 80 ? 1 : 2);
    moving.items.push_back({0, mean, normal});
    if (k < 80) walls.push_back({mean, normal, 0});
  }
  const SurfelIndex index(walls, 1.0);
  EXPECT_NEAR(8.0 / 9.0, match_score(index, moving, SE3{}, 0.9, 0.1), 1e-9);
  // Two directions of three; that of the fewest a little less, since a stray surfel is no direction.
  EXPECT_NEAR(2.0 / 3.0, balanced_score(index, moving, SE3{}, 0.9, 0.1), 0.03);
  moving.items.clear();
  EXPECT_EQ(0.0, balanced_score(index, moving, SE3{}, 0.9, 0.1));
}

TEST(BalancedScore, AsksTheNearestSurfelAndNoneThatLeansInto) {
  const Vector3d leaning = Vector3d(0.2, 0, 1).normalized();
  const SurfelIndex index({{Vector3d::Zero(), Vector3d::UnitZ(), 0}, {Vector3d(1, 0, 0), leaning, 0}}, 1.0);
  MovingSurfels moving{{SE3{}}, {{0, Vector3d(0, 0, 0.2), Vector3d::UnitZ()}}};
  EXPECT_EQ(1.0, match_score(index, moving, SE3{}, 0.9, 0.06));
  EXPECT_EQ(0.0, balanced_score(index, moving, SE3{}, 0.9, 0.06));
  moving.items[0].mean.z() = 0.05;
  EXPECT_NEAR(1.0, balanced_score(index, moving, SE3{}, 0.9, 0.06), 1e-9);
}

TEST(RefineRegistration, EndsWithinTheSurfelsOwnNoise) {
  const Room room(12);
  Random random(13);
  const SE3 start = off_by(room.truth.T_base_sensor[1], 3.0, 0.1, random);
  const SE3 coarse = refine_registration(room.coarse(), room.moving, start, 0.8, 0.3);
  const SE3 X = refine_registration(room.fine(), room.moving, coarse, 0.3, 0.08);
  EXPECT_THAT(X, SE3Near(room.truth.T_base_sensor[1], 0.2, 10.0));
  EXPECT_NEAR(1.0, X.R.determinant(), 1e-12);
}

TEST(NearerToGuess, IsLeftOnlyForWhatFitsClearlyBetterAndTellsOfTheOther) {
  const SE3 here;
  const SE3 above{Matrix3d::Identity(), Vector3d(0.0, 0.0, 0.76)};
  const SE3 aside{Matrix3d::Identity(), Vector3d(0.5, 0.0, 0.0)};
  const RegistrationResult near{here, 0.6, 0.2, aside};

  const RegistrationResult kept = nearer_to_guess(near, {above, 0.7, 0.6, here});
  EXPECT_EQ(0.0, kept.X.t.norm());
  EXPECT_EQ(0.6, kept.score);
  EXPECT_EQ(0.7, kept.runner_up_score);
  EXPECT_EQ(0.76, kept.runner_up.t.z());

  // The same place is no rival, and one that fits worse than the rival so far is none either.
  const RegistrationResult same = nearer_to_guess(near, {here, 0.61, 0.1, above});
  EXPECT_EQ(0.2, same.runner_up_score);
  EXPECT_EQ(0.5, same.runner_up.t.x());
  // It may be the next best of what was found elsewhere.
  EXPECT_EQ(0.76, nearer_to_guess(near, {here, 0.61, 0.5, above}).runner_up.t.z());

  const RegistrationResult left = nearer_to_guess(near, {above, 0.9, 0.6, here});
  EXPECT_EQ(0.76, left.X.t.z());
  EXPECT_EQ(0.6, left.runner_up_score);
}

TEST(Thinned, KeepsTheNumberAskedForEvenlyAndInOrder) {
  MovingSurfels moving;
  for (int i = 0; i < 1000; ++i) moving.items.push_back({i, Vector3d::Zero(), Vector3d::UnitZ()});
  const MovingSurfels few = thinned(moving, 300);
  ASSERT_EQ(300U, few.items.size());
  for (int i = 0; i < 300; ++i) EXPECT_EQ(i * 10 / 3, few.items[static_cast<std::size_t>(i)].place);
  EXPECT_EQ(1000U, thinned(moving, 1000).items.size());
  EXPECT_EQ(1000U, thinned(moving, 5000).items.size());
}

TEST(RefineRegistration, HoldsBackWhatSurfacesLeaveOpen) {
  std::vector<PlacedSurfel> floor;
  MovingSurfels moving{{SE3{}}, {}};
  for (double x = -4.0; x <= 4.0; x += 0.25) {
    for (double y = -4.0; y <= 4.0; y += 0.25) {
      floor.push_back({{x, y, -1.0}, Vector3d::UnitZ(), 0});
      if (std::abs(x) < 2.0 && std::abs(y) < 2.0) moving.items.push_back({0, {x, y, -1.0}, Vector3d::UnitZ()});
    }
  }
  const SurfelIndex index(floor, 0.5);
  const SE3 start{Matrix3d::Identity(), Vector3d(0.2, -0.1, 0.05)};
  const SE3 open = refine_registration(index, moving, start, 0.3, 0.08);
  EXPECT_NEAR(open.t.head<2>().norm(), start.t.head<2>().norm(), 0.02);
  EXPECT_NEAR(open.t.z(), 0.0, 1e-3);
  const SE3 held = refine_registration(index, moving, start, 0.3, 0.08, 1.0);
  EXPECT_LT(held.t.norm(), 0.01);
}

}  // namespace
}  // namespace rigcal
