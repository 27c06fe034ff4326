#include "core/start/turning.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/make_cells.h"
#include "tests/support/make_planes.h"
#include "tests/support/se3_matchers.h"

namespace rigcal {
namespace {

const Vector3d foot(0.28, -0.12, 0.0);

// What the base LiDAR of a turning rig saw of a room.
struct TurningRun {
  RigState truth;
  std::vector<PatchSurfels> base_patches;

  TurningRun(int stops, std::uint64_t seed) : truth(turning_rig(stops, foot)) {
    truth.T_base_sensor.resize(1);
    Random random(seed);
    base_patches = extract_surfels(
        make_patches(make_room(), truth, View{120.0, to_rad(50.0), {0.02, 0.0, 0.0005}}, random), SurfelOptions{});
  }
};

TEST(PosesFromRotations, RecoverTheFootOfTheAxis) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const TurningRun run(10, seed);
    Random random(100 + seed);
    std::vector<Matrix3d> R;
    // As a gyro tells them: 0.03 degrees of error each step.
    for (const SE3& T : run.truth.T_G_base) R.push_back(T.R * random_pose(random, to_rad(0.03), 0.0).R);
    const std::vector<SE3> poses = poses_from_rotations(run.base_patches, R);
    ASSERT_EQ(R.size(), poses.size());
    for (std::size_t j = 0; j < poses.size(); ++j) {
      EXPECT_EQ(R[j], poses[j].R);
      // The foot is good to a centimetre (surfels of a few millimetres, tolerance 10 cm), a pose to twice that.
      EXPECT_LT((poses[j].t - run.truth.T_G_base[j].t).norm(), 0.02) << "stop " << j;
    }
  }
}

TEST(PosesFromRotations, LeaveTheFootAtZeroWhereNothingIsSeen) {
  const std::vector<Matrix3d> R{Matrix3d::Identity(), exp_so3(Vector3d(0.0, 0.0, 1.0))};
  const std::vector<SE3> poses = poses_from_rotations({}, R);
  ASSERT_EQ(2U, poses.size());
  EXPECT_THAT(poses[1], SE3Near(SE3{R[1], Vector3d::Zero()}, 0.0, 0.0));
}

}  // namespace
}  // namespace rigcal
