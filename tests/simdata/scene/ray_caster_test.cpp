#include "simdata/scene/ray_caster.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "simdata/scene/random_vectors.h"
#include "simdata/scene/scene_file.h"
#include "simdata/scene/scene_shapes.h"

namespace rigcal::sim {
namespace {

TEST(RayCaster, AgreesWithTryingEveryPrimitive) {
  for (const char* name : {"courtyard", "room", "sparse"}) {
    const auto scene = load_scene(name);
    ASSERT_TRUE(scene.has_value());
    const RayCaster caster(*scene);
    const RayCaster::People people = caster.people_at(7.3);
    Random random(17);
    int hits = 0;
    for (int i = 0; i < 1500; ++i) {
      const Vector3d origin = scene->T_scene_table.t + 0.5 * random_normal3(random);
      const Vector3d direction = random_direction(random);
      const auto quick = caster.cast(origin, direction, people, 300.0);
      const auto slow = caster.cast_by_brute_force(origin, direction, people, 300.0);
      ASSERT_EQ(slow.has_value(), quick.has_value()) << name << " ray " << i;
      if (!quick) continue;
      ++hits;
      // The same arithmetic on the same primitive, or on one that touches it there.
      ASSERT_NEAR(slow->range, quick->range, 1e-9);
    }
    EXPECT_GT(hits, 700) << name;
  }
}

TEST(RayCaster, SeesABoxWhereItStands) {
  Scene scene;
  scene.materials = {{"a", 40.0}, {"b", 60.0}};
  add_box(scene, {Matrix3d::Identity(), Vector3d(5.0, 0.0, 0.0)}, Vector3d(2.0, 2.0, 2.0), 1);
  const RayCaster caster(scene);
  const auto hit = caster.cast(Vector3d::Zero(), Vector3d::UnitX(), {}, 100.0);
  ASSERT_TRUE(hit.has_value());
  EXPECT_NEAR(4.0, hit->range, 1e-12);
  EXPECT_EQ(1, hit->material);
  EXPECT_NEAR(-1.0, hit->normal.x(), 1e-12);
  EXPECT_FALSE(caster.cast(Vector3d::Zero(), Vector3d::UnitY(), {}, 100.0).has_value());
  EXPECT_FALSE(caster.cast(Vector3d::Zero(), Vector3d::UnitX(), {}, 3.9).has_value());
}

TEST(RayCaster, SeesACylinderFromAsideAndItsLid) {
  Scene scene;
  scene.materials = {{"a", 40.0}};
  add_cylinder(scene, {Vector3d(3.0, 0.0, 0.0), Vector3d::UnitZ(), 2.0, 0.5, 0});
  const RayCaster caster(scene);
  EXPECT_NEAR(2.5, caster.cast({0.0, 0.0, 1.0}, Vector3d::UnitX(), {}, 100.0)->range, 1e-12);
  EXPECT_NEAR(3.0, caster.cast({3.2, 0.1, 5.0}, -Vector3d::UnitZ(), {}, 100.0)->range, 1e-12);
  EXPECT_FALSE(caster.cast({0.0, 0.0, 2.1}, Vector3d::UnitX(), {}, 100.0).has_value());
}

TEST(RayCaster, SeesTheBackOfAWindowRecessedBehindItsWall) {
  Scene scene;
  scene.materials = {{"wall", 40.0}, {"glass", 10.0}};
  Windows windows;
  windows.count = 2;
  windows.recess = 0.15;
  windows.material = 1;
  add_facade(scene, {-3.0, 5.0, 0.0}, {3.0, 5.0, 0.0}, 3.0, windows, 0);
  const RayCaster caster(scene);
  const auto pane = caster.cast({-1.5, 0.0, 1.5}, Vector3d::UnitY(), {}, 100.0);
  const auto wall = caster.cast({0.0, 0.0, 1.5}, Vector3d::UnitY(), {}, 100.0);
  ASSERT_TRUE(pane && wall);
  EXPECT_NEAR(5.15, pane->range, 1e-12);
  EXPECT_EQ(1, pane->material);
  EXPECT_NEAR(5.0, wall->range, 1e-12);
}

TEST(RayCaster, SeesPeopleWhereTheyAreAtTheTime) {
  Scene scene;
  scene.materials = {{"cloth", 30.0}};
  Person person;
  person.path = {Vector3d(5.0, -10.0, 0.0), Vector3d(5.0, 10.0, 0.0)};
  person.speed_m_s = 1.0;
  scene.people.push_back(person);
  const RayCaster caster(scene);
  const Vector3d eye(0.0, 0.0, 1.1);
  EXPECT_FALSE(caster.cast(eye, Vector3d::UnitX(), caster.people_at(0.0), 100.0).has_value());
  const auto hit = caster.cast(eye, Vector3d::UnitX(), caster.people_at(10.0), 100.0);
  ASSERT_TRUE(hit.has_value());
  EXPECT_NEAR(5.0, hit->range, 0.3);  // the trunk's radius
  // There and back again: 40 m later the person is where it was.
  EXPECT_TRUE(caster.cast(eye, Vector3d::UnitX(), caster.people_at(50.0), 100.0).has_value());
}

}  // namespace
}  // namespace rigcal::sim
