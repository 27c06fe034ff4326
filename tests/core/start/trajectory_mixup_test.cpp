#include "core/start/trajectory_mixup.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "simdata/scene/scene_file.h"
#include "tests/core/start/light_run.h"

namespace rigcal {
namespace {

class TrajectoryMixupTest : public testing::Test {
 protected:
  TrajectoryMixupTest() : run_(courtyard()) {
    for (const SE3& T : run_.truth.T_G_base) poses_.emplace_back(T);
  }
  static sim::LightRig courtyard() {
    const auto scene = sim::load_scene("courtyard");
    sim::LightRigOptions options;
    options.turntable.stops = 10;
    options.shots_per_patch = LightRun::shots_per_patch;
    auto light = sim::make_light_rig(*scene, options);
    EXPECT_TRUE(light.has_value());
    return *std::move(light);
  }
  [[nodiscard]] TrajectoryMixup find() const { return trajectory_mixup(run_.surfels, 0, poses_); }

  LightRun run_;
  std::vector<std::optional<SE3>> poses_;
};

TEST_F(TrajectoryMixupTest, IsNoneWherePosesAreRightOrRough) {
  EXPECT_EQ(find(), TrajectoryMixup::none);
  Random random(1);
  for (auto& T : poses_) {
    const Vector3d turn(random.normal(), random.normal(), random.normal());
    T = *T * SE3{exp_so3(to_rad(1.5) * turn.normalized()), 0.05 * Vector3d(random.normal(), random.normal(), 0.0)};
  }
  EXPECT_EQ(find(), TrajectoryMixup::none);
  EXPECT_STREQ(to_words(find()), "");
}

TEST_F(TrajectoryMixupTest, IsNamed) {
  const std::vector<std::optional<SE3>> right = poses_;
  for (auto& T : poses_) T = T->inverse();
  EXPECT_EQ(find(), TrajectoryMixup::inverse);
  poses_ = right;
  for (auto& T : poses_) T->t *= 1000.0;
  EXPECT_EQ(find(), TrajectoryMixup::millimetres);
  poses_ = right;
  for (auto& T : poses_) {
    // w x y z, read as x y z w.
    const Eigen::Quaterniond q(T->R);
    T->R = Eigen::Quaterniond(q.z(), q.w(), q.x(), q.y()).toRotationMatrix();
  }
  EXPECT_EQ(find(), TrajectoryMixup::w_first);
}

TEST_F(TrajectoryMixupTest, IsNotSoughtWithFewerThanTwoPoses) {
  for (std::size_t j = 1; j < poses_.size(); ++j) poses_[j].reset();
  EXPECT_EQ(find(), TrajectoryMixup::none);
}

}  // namespace
}  // namespace rigcal
