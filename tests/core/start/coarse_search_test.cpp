#include "core/start/coarse_search.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/base/best_apart.h"
#include "core/base/random.h"

namespace rigcal {
namespace {

Vector3d some_direction(Random& random) {
  return Vector3d(random.normal(), random.normal(), random.normal()).normalized();
}

Vector3d some_place(Random& random, double reach_m) {
  return {random.uniform(-reach_m, reach_m), random.uniform(-reach_m, reach_m), random.uniform(-reach_m, reach_m)};
}

// Surfels of a scene, and the same seen from two places by something that stands at the identity.
struct Scene {
  std::vector<PlacedSurfel> map;
  MovingSurfels moving{{SE3{}, {exp_so3(Vector3d(0.0, 0.0, 0.7)), Vector3d(1.0, 0.5, 0.0)}}, {}};

  explicit Scene(Random& random) {
    for (int i = 0; i < 300; ++i) {
      const int place = i % 2;
      map.push_back({some_place(random, 4.0), some_direction(random), 0});
      const SE3 back = moving.places[static_cast<std::size_t>(place)].inverse();
      moving.items.push_back({place, back * map.back().mean, back.R * map.back().normal});
    }
  }
};

std::vector<SE3> some_poses(Random& random, int count) {
  std::vector<SE3> out;
  for (int i = 0; i < count; ++i) {
    const double share = random.uniform(0.0, 1.0);
    out.push_back({exp_so3(0.5 * share * some_direction(random)), some_place(random, 0.6 * share)});
  }
  return out;
}

void expect_same(const std::vector<ScoredPose>& expected, const std::vector<ScoredPose>& found) {
  ASSERT_EQ(expected.size(), found.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_EQ(expected[i].score, found[i].score);
    EXPECT_EQ(expected[i].X.t, found[i].X.t);
    EXPECT_EQ(expected[i].X.R, found[i].X.R);
  }
}

TEST(BestMatches, AreThoseOfAskingEveryPoseToTheEnd) {
  Random random(3);
  const Scene scene(random);
  const SurfelIndex index(scene.map, 0.5);
  const SurfelMatchTolerance tolerance{std::cos(to_rad(20.0)), 0.2};
  for (const double apart_m : {0.0, 0.05, 0.3, 0.8}) {
    const auto near = [&](const SE3& a, const SE3& b) { return (a.t - b.t).norm() < apart_m; };
    for (const int count : {0, 3, 40, 500}) {
      const std::vector<SE3> poses = some_poses(random, count);
      std::vector<ScoredPose> all;
      for (const SE3& X : poses)
        all.push_back({X, match_score(index, scene.moving, X, tolerance.min_cosine, tolerance.max_plane_distance_m)});
      for (const std::size_t most : {std::size_t{0}, std::size_t{1}, std::size_t{6}, std::size_t{600}}) {
        const auto same = [&](const ScoredPose& a, const ScoredPose& b) { return near(a.X, b.X); };
        expect_same(best_apart(all, most, same), best_matches(index, scene.moving, poses, tolerance, most, near));
      }
    }
  }
}

TEST(BestMatches, OfNoSurfelsAreTheFirstPoses) {
  Random random(4);
  const SurfelIndex index({}, 0.5);
  const std::vector<SE3> poses = some_poses(random, 3);
  const auto found = best_matches(index, {}, poses, {0.9, 0.1}, 2, [](const SE3&, const SE3&) { return false; });
  expect_same({{poses[0], 0.0}, {poses[1], 0.0}}, found);
}

}  // namespace
}  // namespace rigcal
