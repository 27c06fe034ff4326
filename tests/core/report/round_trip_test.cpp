// What core/report writes, core/io reads back.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "core/io/extrinsics_file.h"
#include "core/io/tum_file.h"
#include "core/report/result_folder.h"
#include "core/report/result_texts.h"
#include "tests/support/make_result.h"

namespace rigcal {
namespace {

TEST(ResultRoundTrip, GivesBackTheSameTransformsStatusAndCovariance) {
  const CalibrationResult result = make_result();
  const Expected<ExtrinsicsFile> file = parse_extrinsics(extrinsics_yaml(result), "extrinsics.yaml");
  ASSERT_TRUE(file) << file.error().message();
  EXPECT_EQ(file->base, "avia");
  const SensorResult& weak = result.sensors[1];
  const SE3& read = file->T_base_sensor.at(weak.name);
  EXPECT_EQ(read.t, weak.T_base_sensor->t);
  // The rotation goes through a unit quaternion, which costs some roundings.
  EXPECT_LT((read.R - weak.T_base_sensor->R).cwiseAbs().maxCoeff(), 1e-15);
  EXPECT_EQ(file->covariance.at(weak.name), weak.covariance);
  EXPECT_EQ(file->status.at(weak.name), "weak");
  EXPECT_EQ(file->status.at("mid40_right"), "failed");
  EXPECT_EQ(file->T_base_sensor.count("mid40_right"), 0U);
}

TEST(ResultRoundTrip, GivesBackTheTrajectory) {
  const CalibrationResult result = make_result();
  const Expected<std::vector<TumPose>> poses = parse_tum(trajectory_tum(result), "trajectory.tum");
  ASSERT_TRUE(poses) << poses.error().message();
  ASSERT_EQ(poses->size(), 2U);
  EXPECT_EQ((*poses)[0].stamp_ns, 1'700'000'001'000'000'000);
  EXPECT_EQ((*poses)[1].stamp_ns, 1'700'000'007'000'000'000);
  EXPECT_EQ((*poses)[1].pose.t, result.trajectory[2].T_G_base.t);
}

}  // namespace
}  // namespace rigcal
